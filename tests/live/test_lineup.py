"""Lineups: runs of one world side by side, on one timeline, seen by one camera."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

import numpy as np
import pytest

from evastudio.demonstrations.store import Store
from evastudio.errors import BusyError, ConflictError, InvalidInputError, NotFoundError
from evastudio.live import lineups as limits
from evastudio.live import reel
from evastudio.live.headless import make_scene, record
from evastudio.live.lineup import APART_M, Lineup, Ran
from evastudio.live.lineups import Entrant, Lineups, World, flown
from evastudio.live.picture import Picture
from evastudio.live.turned import as_seen, placed
from evastudio.pilots.scripted import find_pilot
from evastudio.workspace import Workspace
from evastudio.world.bodies import Camera
from evastudio.world.scene import Scene

UP = np.array([0.0, 0.0, 1.0])


def camera(x: float, y: float, z: float, *at: float) -> Camera:
    return Camera(np.array([x, y, z]), np.array(at), UP)


@pytest.fixture(scope="module")
def runs(asteroids: Callable[..., Scene]) -> list[Ran]:
    """Careful, careful again, and straight through the same dense field."""
    scene, seed = asteroids(density=4.0), 11
    start = scene.worlds([seed])
    careful, straight = (
        Ran(name, flown(scene, find_pilot(name), seed, start))
        for name in ("scripted:careful", "straight")
    )
    return [careful, careful, straight]


@pytest.fixture
def lineup(runs: list[Ran]) -> Iterator[Lineup]:
    made = Lineup("test", runs)
    yield made
    made.close()


class Screen:
    """What a view was told to draw."""

    def __init__(self) -> None:
        self.seen: list[Picture] = []

    def __call__(self, picture: Picture) -> None:
        self.seen.append(picture)

    @property
    def last(self) -> Picture:
        return self.seen[-1]


def test_those_that_do_the_same_never_part_and_others_do_once(lineup: Lineup) -> None:
    first, second, third = lineup.columns
    assert (first.parts_s, second.parts_s) == (None, None)
    assert third.parts_s is not None
    assert lineup.parts_s == third.parts_s
    step = round(third.parts_s / lineup.scene.dt_s)
    apart = [np.linalg.norm(third.reel.place(s) - first.reel.place(s)) for s in (step - 1, step)]
    assert apart[0] <= APART_M < apart[1]
    assert third.outcome == "hit"
    assert lineup.length_s == first.length_s > third.length_s


def test_all_columns_show_the_same_moment_or_their_own_end(lineup: Lineup) -> None:
    screens = [Screen() for _ in lineup.columns]
    for column, screen in zip(lineup.columns, screens, strict=True):
        column.watch(screen)
        assert screen.last.fresh
    standing = lineup.seek(1.0)
    assert standing.position_s == pytest.approx(1.0)
    first, second, third = (screen.last.snapshot for screen in screens)
    assert np.array_equal(first["position"], second["position"])
    assert np.array_equal(third["position"], lineup.columns[2].reel.shown(15.0)["position"])
    lineup.seek(lineup.length_s + 100.0)
    ends = [screen.last.snapshot["position"] for screen in screens]
    for column, end in zip(lineup.columns, ends, strict=True):
        assert np.array_equal(end, column.reel.moment(column.reel.last)["position"])
    assert len(screens[0].last.lines) == 3
    widths = [line.pixels for line in screens[2].last.lines]
    assert widths[2] > widths[0] == widths[1]
    with pytest.raises(InvalidInputError, match="speed"):
        lineup.roll(9.0)
    with pytest.raises(NotFoundError, match="camera"):
        lineup.look_through("nowhere")


def test_it_rolls_to_the_end_stands_there_and_begins_again(lineup: Lineup) -> None:
    arrived = Screen()
    lineup.columns[0].watch(arrived)
    lineup.seek(lineup.length_s - 0.5)
    assert lineup.roll(8.0).speed == 8.0
    until = time.monotonic() + 20.0
    while lineup.standing().speed and time.monotonic() < until:
        lineup.standing()
    standing = lineup.standing()
    assert (standing.speed, standing.position_s) == (0.0, pytest.approx(lineup.length_s))
    assert lineup.roll(0.25).position_s < 1.0
    assert len(arrived.seen) > 2


def test_a_turn_of_one_column_turns_the_others_by_as_much(lineup: Lineup) -> None:
    screens = [Screen() for _ in lineup.columns]
    for column, screen in zip(lineup.columns, screens, strict=True):
        column.watch(screen)
    lineup.seek(3.0)
    before = screens[2].last.camera
    drawn = len(screens[2].seen)
    # From behind the ship to its side, twice as far away.
    turned = placed(before, camera(8.0, 30.0, 5.0, 8.0, 0.0, 0.0))
    lineup.columns[2].turned(before, turned)
    assert lineup.standing().turned
    assert len(screens[2].seen) == drawn  # whoever turned it is there already
    expected = as_seen(lineup.scene.camera(screens[2].last.snapshot), turned)
    for screen in screens[:2]:
        own = lineup.scene.camera(screen.last.snapshot)
        told = as_seen(own, screen.last.camera)
        assert told.position == pytest.approx(expected.position)
        assert told.look_at == pytest.approx(expected.look_at)
    # It stays so as time goes on, and until the scene's own is asked for.
    lineup.seek(4.0)
    for screen in screens:
        own = lineup.scene.camera(screen.last.snapshot)
        assert as_seen(own, screen.last.camera).position == pytest.approx(expected.position)
    assert not lineup.look_through().turned
    own = lineup.scene.camera(screens[0].last.snapshot)
    assert screens[0].last.camera.position == pytest.approx(own.position)


def test_a_camera_as_another_sees_it_is_placed_where_it_was() -> None:
    rng = np.random.default_rng(3)
    for _ in range(50):
        one, two = (Camera(rng.normal(size=3) * 50, rng.normal(size=3) * 50, UP) for _ in range(2))
        again = placed(one, as_seen(one, two))
        for name in ("position", "look_at", "up"):
            assert getattr(again, name) == pytest.approx(getattr(two, name))
    # A camera that looks straight down has no left of its own, and still places points.
    down = camera(1.0, 2.0, 9.0, 1.0, 2.0, 0.0)
    again = placed(down, as_seen(down, camera(4.0, 5.0, 6.0, 7.0, 8.0, 9.0)))
    assert again.position == pytest.approx([4.0, 5.0, 6.0])


def test_a_take_is_shown_beside_pilots_that_begin_where_it_did(
    workspace: Workspace, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(limits, "LONGEST_S", 4.0)
    made = record(workspace, "asteroids", "scripted:human", minutes=0.05, seed=5)
    other = record(workspace, "asteroids", "scripted:human", minutes=0.05, seed=6)
    with Store(workspace.store_url) as store:
        (take,) = store.takes(made["session"])
        (elsewhere,) = store.takes(other["session"])
        open_ones = Lineups(workspace, store)
        world = World("asteroids", {}, 0)
        entrants = [Entrant(take=take.id), Entrant("straight")]
        lineup = open_ones.open("", world, entrants).lineup
        shown, beside = lineup.columns
        data = store.load_take(take.id)
        assert shown.reel.last == take.pairs
        for name in data.snapshots.moving:
            assert np.array_equal(beside.reel.moment(0)[name], data.snapshots[name][:1])
        assert shown.title == "Take 1 of scripted:human 5"
        with pytest.raises(ConflictError, match="different worlds"):
            open_ones.open("", world, [Entrant(take=take.id), Entrant(take=elsewhere.id)])
        open_ones.close_all()


def test_in_a_crowd_the_others_do_again_what_they_did(
    workspace: Workspace, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(limits, "LONGEST_S", 4.0)
    made = record(workspace, "crowd", "scripted:shy", minutes=0.1, seed=5, options={"people": 6})
    with Store(workspace.store_url) as store:
        take = store.takes(made["session"])[0]
        open_ones = Lineups(workspace, store)
        entrants = [Entrant(take=take.id), Entrant("crowd-hurried")]
        lineup = open_ones.open("", World("crowd", {}, 0), entrants).lineup
        shown, beside = (column.reel for column in lineup.columns)
        lead = int(shown.moment(0)["lead"][0])
        before, after = (beside.moment(step)["position"][0] for step in (0, beside.last))
        rest = np.arange(len(before)) != lead
        assert np.array_equal(before[rest], after[rest])  # a program led: the others stood
        open_ones.close_all()


def test_a_lineup_is_its_owners_and_of_many_the_oldest_goes(
    workspace: Workspace, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(limits, "LONGEST_S", 1.0)
    make_scene(workspace, "asteroids")
    with Store(workspace.store_url) as store:
        open_ones = Lineups(workspace, store)
        world = World("asteroids", {"density": 0.1}, 3, 1)
        pair = [Entrant("straight"), Entrant("scripted:careful")]
        names = [open_ones.open("Vera", world, pair).lineup.name for _ in range(4)]
        assert [one.lineup.name for one in open_ones.all("Vera")] == names[1:]
        assert open_ones.all("") == []
        with pytest.raises(NotFoundError, match="lineup"):
            open_ones.get("", names[1])
        found = open_ones.get("Vera", names[1]).lineup
        column = open_ones.column(found.columns[0].name)
        assert column is not None
        assert column[1] is found.columns[0]
        with pytest.raises(InvalidInputError, match="2 to 4"):
            open_ones.open("Vera", world, pair * 3)
        with pytest.raises(InvalidInputError, match="not both"):
            Entrant("straight", 3)
        open_ones.close_all()
        assert open_ones.column(found.columns[0].name) is None


def test_what_lineups_hold_in_memory_is_bounded(
    workspace: Workspace, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(limits, "LONGEST_S", 2.0)
    with Store(workspace.store_url) as store:
        open_ones = Lineups(workspace, store)
        world = World("asteroids", {"density": 0.1}, 3)
        pair = [Entrant("straight"), Entrant("scripted:careful")]
        first = open_ones.open("Vera", world, pair).lineup
        assert first.bytes > 0
        monkeypatch.setattr(limits, "MOST_BYTES", 2 * first.bytes)
        second = open_ones.open("Rolf", world, pair).lineup
        with pytest.raises(BusyError, match="2 lineups are open already"):
            open_ones.open("Vera", world, pair)
        open_ones.close(second.name)
        open_ones.open("Vera", world, pair)
        monkeypatch.setattr(reel, "MOST_BYTES", first.bytes // 4)
        with pytest.raises(InvalidInputError, match="straight is too large"):
            open_ones.open("Vera", world, pair)
        open_ones.close_all()

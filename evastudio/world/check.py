"""The conformance suite: what every scene must do, run on any scene file."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from evastudio.errors import NotFoundError
from evastudio.world.loading import load_scene_file
from evastudio.world.scene import RUNNING, Scene, world_seeds
from evastudio.world.snapshot import Snapshot
from evastudio.world.spaces import Array

STEPS = 40
WORLDS = 5


@dataclass(frozen=True)
class Finding:
    """One rule, and whether the scene keeps it."""

    rule: str
    problem: str | None
    """What is wrong, or None."""


def check_file(path: str | Path, seed: int = 0) -> list[Finding]:
    """Run every rule on the scene of a Python file. Raises as `load_scene_file` does."""
    return check_scene(load_scene_file(Path(path)), seed)


def check_scene(scene_class: type[Scene], seed: int = 0) -> list[Finding]:
    """Run every rule on a scene with its default options."""
    findings: list[Finding] = []
    try:
        scene = scene_class()
    except Exception as error:  # a user's code
        return [Finding("can be made with its default options", _told(error))]
    for rule, test in _rules(scene, seed):
        try:
            test()
        except AssertionError as failure:
            findings.append(Finding(rule, str(failure)))
        except Exception as error:  # a user's code
            findings.append(Finding(rule, _told(error)))
        else:
            findings.append(Finding(rule, None))
    return findings


def _rules(scene: Scene, seed: int) -> Iterator[tuple[str, Callable[[], None]]]:
    seeds = world_seeds(seed, WORLDS)

    def declares() -> None:
        _need(scene.outcomes[0] == RUNNING, f"outcomes must begin with {RUNNING!r}")
        _need(scene.successes <= set(scene.outcomes[1:]), "successes must be among outcomes")
        _need(scene.dt_s > 0 and scene.render_hz > 0, "dt_s and render_hz must be positive")
        _need(len(scene.perceptions) > 0, "perceptions must hold at least one")
        named = all(name == view.name for name, view in scene.perceptions.items())
        _need(named, "perceptions must be keyed by their names")
        fields = set(scene.action.names)
        for control in scene.controls:
            _need(control.field in fields, f"control {control.label!r} moves no action field")
        for signal in scene.signals:
            moved = {signal.field, *(signal.place or ())}
            _need(moved <= fields, f"signal {signal.label!r} sets no action field")
        bounded = np.isfinite(scene.action.low).all() and np.isfinite(scene.action.high).all()
        _need(bool(bounded), "every action field needs finite bounds")

    def repeats() -> None:
        for first, second in zip(_walk(scene, seeds, seed), _walk(scene, seeds, seed), strict=True):
            _same(first, second, "the same seed and actions gave two different worlds")

    def batches() -> None:
        walks = [_walk(scene, [one], seed, row) for row, one in enumerate(seeds)]
        for step, together in enumerate(_walk(scene, seeds, seed)):
            for row, alone in enumerate(walks):
                _same(
                    together.take(slice(row, row + 1)),
                    alone[step],
                    f"world {row} alone differs from the same world in a batch, at step {step}",
                )

    def pure() -> None:
        start = scene.worlds(seeds)
        copy = {name: array.copy() for name, array in {**start.fixed, **start.moving}.items()}
        scene.step(start, _actions(scene, seed, WORLDS, 1)[0])
        for name, array in copy.items():
            unchanged = np.array_equal(array, start[name])
            _need(unchanged, f"step changed the array {name!r} of the snapshot it was given")

    def finite() -> None:
        for snapshot in _walk(scene, seeds, seed):
            for name, array in {**snapshot.fixed, **snapshot.moving}.items():
                _need(bool(np.isfinite(array).all()), f"array {name!r} holds NaN or infinity")
            codes = scene.outcome(snapshot)
            _need(codes.shape == (WORLDS,), f"outcome has shape {codes.shape}")
            _need(
                bool(((codes >= 0) & (codes < len(scene.outcomes))).all()),
                "outcome is not in outcomes",
            )
            told = scene.notice(snapshot)
            shape = (WORLDS, *scene.characters, len(scene.signs))
            _need(told.shape == shape, f"notice has shape {told.shape}, expected {shape}")
            _need(bool(np.isfinite(told).all()), "a sign is not finite")
            progress = scene.progress(snapshot)
            _need(bool(((progress >= 0) & (progress <= 1)).all()), "progress leaves 0 to 1")

    def perceives() -> None:
        actions = _actions(scene, seed, WORLDS, STEPS)
        for name, view in scene.perceptions.items():
            for step, snapshot in enumerate(_walk(scene, seeds, seed)[:STEPS]):
                percept = view.perceive(snapshot)
                shape = (WORLDS, *scene.characters, view.state.size)
                _need(
                    percept.states.shape == shape,
                    f"{name}: states have shape {percept.states.shape}, expected {shape}",
                )
                _need(bool(np.isfinite(percept.states).all()), f"{name}: a state is not finite")
                inside = (percept.states >= view.state.low) & (percept.states <= view.state.high)
                if not inside.all():
                    whole = inside.reshape(-1, view.state.size).all(axis=0)
                    outside = view.state.names[int(np.argmin(whole))]
                    raise AssertionError(f"{name}: {outside!r} leaves the range it declares")
                own = view.to_own(percept.frame, actions[step])
                shape = (WORLDS, *scene.characters, scene.chosen(view).size)
                _need(own.shape == shape, f"{name}: to_own gives {own.shape}, expected {shape}")
                back = view.to_own(percept.frame, view.to_world(percept.frame, own))
                close = np.allclose(back, own, rtol=1e-9, atol=1e-9)
                _need(close, f"{name}: to_own does not undo to_world")
                if view.action is None:
                    back = view.to_world(percept.frame, own)
                    close = np.allclose(back, actions[step], rtol=1e-9, atol=1e-9)
                    _need(close, f"{name}: to_world does not undo to_own")
                for row in range(WORLDS):
                    alone = view.perceive(snapshot.take(slice(row, row + 1))).states[0]
                    equal = np.array_equal(alone, percept.states[row])
                    _need(equal, f"{name}: a state differs between one world and a batch")

    def draws() -> None:
        meshes = scene.meshes()
        for snapshot in (scene.worlds(seeds), _walk(scene, seeds, seed)[-1]):
            bodies = scene.bodies(snapshot)
            names = [body.name for body in bodies]
            _need(len(names) == len(set(names)), "two bodies share a name")
            for body in bodies:
                _need(body.mesh in meshes, f"body {body.name!r} names no mesh: {body.mesh!r}")
                parts = (body.positions, body.wxyzs, body.scales)
                _need(
                    all(len(part) == len(body.positions) for part in parts)
                    and all(bool(np.isfinite(part).all()) for part in parts),
                    f"body {body.name!r} has arrays of different lengths or not finite",
                )
                colored = body.colors is None or body.colors.shape == (len(body.positions), 3)
                _need(colored, f"body {body.name!r} needs one colour for each instance, or none")
            for name, camera in scene.cameras(snapshot).items():
                points = np.concatenate([camera.position, camera.look_at, camera.up])
                _need(bool(np.isfinite(points).all()), f"the camera {name!r} is not finite")

    def intends() -> None:
        try:
            actions = scene.intention(scene.worlds(seeds))
        except NotFoundError:
            return  # a scene without scripted demonstrators is a scene all the same
        shape = (WORLDS, *scene.characters, scene.action.size)
        _need(actions.shape == shape, f"intention has shape {actions.shape}, expected {shape}")
        _need(bool(np.isfinite(actions).all()), "intention is not finite")

    def guards() -> None:
        actions = _actions(scene, seed, WORLDS, STEPS)
        for step, snapshot in enumerate(_walk(scene, seeds, seed)[:STEPS]):
            instead = scene.instead(snapshot, actions[step])
            shape = actions[step].shape
            _need(instead.shape == shape, f"instead has shape {instead.shape}, expected {shape}")
            inside = (instead >= scene.action.low) & (instead <= scene.action.high)
            _need(bool(inside.all()), "instead gives an action that leaves its range")
            for row in range(WORLDS):
                one = slice(row, row + 1)
                alone = scene.instead(snapshot.take(one), actions[step][one])[0]
                _need(
                    np.array_equal(alone, instead[row]),
                    "instead differs between one world and a batch",
                )

    yield "declares what the studio needs", declares
    yield "repeats exactly from its seed", repeats
    yield "batched equals one by one", batches
    yield "step leaves its snapshot alone", pure
    yield "values are finite and in range", finite
    yield "perceptions fit and turn actions back", perceives
    yield "bodies and camera can be drawn", draws
    yield "intention, if any, gives actions", intends
    yield "what is done instead are actions too", guards


def _actions(scene: Scene, seed: int, worlds: int, steps: int) -> Array:
    rng = np.random.default_rng([seed, 1])
    shape = (steps, worlds, *scene.characters, scene.action.size)
    return scene.action.at(rng.uniform(0.0, 1.0, shape))


def _walk(scene: Scene, seeds: list[int], seed: int, row: int | None = None) -> list[Snapshot]:
    """The snapshots of a walk with random actions; `row` picks the actions of one world."""
    snapshots = [scene.worlds(seeds)]
    for actions in _actions(scene, seed, WORLDS, STEPS):
        chosen = actions if row is None else actions[row : row + 1]
        snapshots.append(scene.step(snapshots[-1], chosen))
    return snapshots


def _same(first: Snapshot, second: Snapshot, problem: str) -> None:
    for name in {**first.fixed, **first.moving}:
        if not np.array_equal(first[name], second[name]):
            raise AssertionError(f"{problem} (array {name!r})")


def _need(true: bool, problem: str) -> None:
    if not true:
        raise AssertionError(problem)


def _told(error: Exception) -> str:
    return f"{type(error).__name__}: {error}"

"""What a store does not take waits in files, in order, and is written once."""

from __future__ import annotations

import contextlib
import os
import resource
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from evastudio.demonstrations import spill as spilling
from evastudio.demonstrations.spill import Spill
from evastudio.demonstrations.spill_file import BEGIN, FINISH, HELD_BYTES, PAIRS, Entry, read_spill
from evastudio.demonstrations.unsaved import unsaved

STORE = "a-store"
FIRST = Entry(BEGIN, "one", {"session": 1}, b"world")


def pairs(number: int, size: int = 10) -> Entry:
    return Entry(PAIRS, "one", {"first_step": number, "steps": 1}, bytes([number]) * size)


def drained(spill: Spill) -> list[Entry]:
    found = []
    while (entry := spill.front()) is not None:
        found.append(entry)
        spill.done()
    return found


@contextlib.contextmanager
def small_files() -> Iterator[None]:
    """No file of this process may grow beyond 2 kB, as on a disk that is full."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (2000, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_a_long_line_keeps_its_order_while_some_go_and_others_come(tmp_path: Path) -> None:
    spill = Spill(STORE, [tmp_path / "unsaved"])
    spill.put(FIRST, FIRST)
    came, gone = [FIRST], []
    for number in range(1, 64):
        came.append(pairs(number, HELD_BYTES // 10))
        spill.put(came[-1], FIRST)
        if number % 3 == 0:
            assert spill.front() == spill.front()
            gone.append(spill.front())
            spill.done()
    assert gone + drained(spill) == came


def test_entries_come_out_as_they_went_in_and_leave_nothing(tmp_path: Path) -> None:
    folder = tmp_path / "unsaved"
    spill = Spill(STORE, [folder])
    end = Entry(FINISH, "one", {"outcome": None, "now": 0.0})
    for entry in (FIRST, pairs(0)):
        spill.put(entry, FIRST)
    assert drained(spill) == [FIRST, pairs(0)]
    for entry in (pairs(1), end):
        spill.put(entry, FIRST)
    assert drained(spill) == [pairs(1), end]
    assert spill.place is not None
    assert read_spill(spill.place).entries == (FIRST,), "nothing that is done with ends it again"
    other = Entry(BEGIN, "two", {"session": 1}, b"world")
    for entry in (other, end):
        spill.put(entry, other)
    assert drained(spill) == [other, end]
    spill.put(pairs(2), FIRST)
    assert read_spill(spill.place).entries == (FIRST, pairs(2)), "it can be read on its own"
    assert drained(spill) == [FIRST, pairs(2)]
    assert spill.close() == ([], 0)
    assert not folder.exists()


def test_what_is_not_done_with_stays_in_the_file(tmp_path: Path) -> None:
    spill = Spill(STORE, [tmp_path])
    for entry in (FIRST, pairs(0), pairs(1)):
        spill.put(entry, FIRST)
    spill.done()
    assert unsaved([tmp_path], STORE) == [], "somebody still writes it"
    (left,), lost = spill.close()
    assert lost == 0
    (found,) = unsaved([tmp_path], STORE)
    assert (found.path, found.takes, found.pairs) == (left, 1, 2)
    assert unsaved([tmp_path], "another-store") == []


@pytest.mark.parametrize("cut", [1, 9, 30])
def test_a_torn_end_is_left_out(tmp_path: Path, cut: int) -> None:
    spill = Spill(STORE, [tmp_path])
    for entry in (FIRST, pairs(0), pairs(1)):
        spill.put(entry, FIRST)
    (left,), _ = spill.close()
    data = left.read_bytes()
    left.write_bytes(data[:-cut])
    found = read_spill(left)
    assert found.entries == (FIRST, pairs(0))
    assert found.torn > 0
    left.write_bytes(data[:-cut] + b"?" * cut)
    assert read_spill(left).entries == (FIRST, pairs(0)), "what is damaged counts as torn"


def test_a_full_disk_moves_the_line_to_the_next_folder(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("no folder")
    spill = Spill(STORE, [tmp_path / "file" / "unsaved", tmp_path / "unsaved"])
    entries = [FIRST, *(pairs(number, 400) for number in range(20))]
    with small_files():
        assert all(spill.put(entry, FIRST) for entry in entries)
    files = sorted((tmp_path / "unsaved").iterdir())
    assert len(files) > 3
    assert all(read_spill(file).entries[0] == FIRST for file in files)
    assert all(read_spill(file).torn == 0 for file in files)
    assert [entry for entry in drained(spill) if entry != FIRST] == entries[1:]
    spill.close()
    assert not list(tmp_path.rglob("*.unsaved"))


def test_without_any_folder_memory_has_to_do_and_has_an_end(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(spilling, "MEMORY_BYTES", 1000)
    (tmp_path / "file").write_text("no folder")
    spill = Spill(STORE, [tmp_path / "file"])
    assert spill.put(FIRST, FIRST)
    assert spill.place is None
    took = [spill.put(pairs(number, 400), FIRST) for number in range(5)]
    assert took == [True, True, True, False, False]
    assert drained(spill) == [FIRST, pairs(0, 400), pairs(1, 400), pairs(2, 400)]


def test_memory_goes_to_a_file_as_soon_as_one_can_be_written(tmp_path: Path) -> None:
    folder = tmp_path / "unsaved"
    folder.write_text("in the way")
    spill = Spill(STORE, [folder])
    spill.put(FIRST, FIRST)
    spill.put(pairs(0), FIRST)
    assert spill.front() == FIRST
    folder.unlink()
    spill.put(pairs(1), FIRST)
    assert spill.place is not None
    assert read_spill(spill.place).entries == (FIRST, pairs(0), pairs(1))
    assert drained(spill) == [FIRST, pairs(0), pairs(1)]
    spill.close()


def test_a_long_line_gives_back_what_is_done_with(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(spilling, "FILE_BYTES", 1000)
    spill = Spill(STORE, [tmp_path])
    for number in range(200):
        spill.put(pairs(number, 400), FIRST)
        if number >= 5:
            spill.done()
            spill.done()  # every file begins with the beginning of its takes
            assert len(list(tmp_path.iterdir())) <= 8
    spill.close()


def test_a_killed_process_leaves_what_it_had_put_in(tmp_path: Path) -> None:
    program = (
        "import sys; from pathlib import Path; from evastudio.demonstrations.spill import Spill\n"
        "from evastudio.demonstrations.spill_file import *\n"
        "first = Entry(BEGIN, 'one', {'session': 1}, b'world')\n"
        "spill = Spill('a-store', [Path(sys.argv[1])])\n"
        "for n in range(100):\n"
        "    spill.put(Entry(PAIRS, 'one', {'first_step': n, 'steps': 1}, b'x' * 1000), first)\n"
        "    print(n, flush=True)\n"
        "sys.stdin.read()\n"
    )
    with subprocess.Popen(
        [sys.executable, "-c", program, str(tmp_path)],
        stdout=subprocess.PIPE,
        stdin=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
    ) as process:
        assert process.stdout is not None
        while process.stdout.readline().strip() != "99":
            pass
        assert unsaved([tmp_path], STORE) == []
        process.kill()
    (found,) = unsaved([tmp_path], STORE)
    assert found.pairs == 100

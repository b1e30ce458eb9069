"""Files that appear only when complete: links, pipes and devices, failures, and writers at once."""

from __future__ import annotations

import errno
import os
import threading
from pathlib import Path

import pytest

from bristle_sim.files import complete_or_absent, is_special


def write(target: Path, text: str) -> None:
    with complete_or_absent(target) as partial:
        partial.write_text(text)


def write_half(target: Path) -> None:
    with complete_or_absent(target) as partial:
        partial.write_text("half")
        raise KeyboardInterrupt


def test_a_file_appears_when_complete_and_a_failure_leaves_the_old_one(tmp_path: Path):
    target = tmp_path / "out.txt"
    with complete_or_absent(target) as partial:
        partial.write_text("old")
        assert partial.parent == tmp_path
        assert not target.exists()
    with pytest.raises(KeyboardInterrupt):
        write_half(target)
    assert target.read_text() == "old"
    assert list(tmp_path.iterdir()) == [target]


@pytest.mark.parametrize("there", [True, False])
def test_a_symbolic_link_stays_one(there: bool, tmp_path: Path):
    (tmp_path / "far").mkdir()
    target = tmp_path / "far" / "out.txt"
    link = tmp_path / "link"
    if there:
        target.write_text("old")
    link.symlink_to(target)
    write(link, "new")
    assert link.is_symlink()
    assert target.read_text() == "new"
    assert list(target.parent.iterdir()) == [target]


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs named pipes")
def test_a_pipe_receives_what_is_complete(tmp_path: Path):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    assert is_special(pipe)
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    with pytest.raises(KeyboardInterrupt):
        write_half(pipe)
    write(pipe, "whole")
    assert os.read(reader, 100) == b"whole"
    os.close(reader)
    assert is_special(pipe)
    assert list(tmp_path.iterdir()) == [pipe]


@pytest.mark.skipif(not Path("/dev/fd").exists(), reason="needs names of open streams")
def test_an_open_stream_goes_on_where_it_is(tmp_path: Path):
    """Its name resolves to the file that it is redirected to, which must be neither replaced nor emptied."""
    target = tmp_path / "redirected"
    with target.open("w") as stream:
        stream.write("before ")
        stream.flush()
        name = Path(f"/dev/fd/{stream.fileno()}")
        assert is_special(name)
        write(name, "whole ")
        stream.write("after")
    assert target.read_text() == "before whole after"
    assert list(tmp_path.iterdir()) == [target]


def test_an_error_names_the_file_that_was_meant(tmp_path: Path):
    target = tmp_path / "nowhere" / "out.txt"
    with pytest.raises(FileNotFoundError) as refusal:
        write(target, "new")
    assert refusal.value.filename == str(target)
    assert (
        str(refusal.value) == f"[Errno {errno.ENOENT}] {os.strerror(errno.ENOENT)}: {str(target)!r}"
    )


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is always full")
def test_a_full_device_is_named():
    with pytest.raises(OSError, match=r"No space left on device: '/dev/full'$"):
        write(Path("/dev/full"), "new")


def test_threads_do_not_share_a_partial_file(tmp_path: Path):
    target = tmp_path / "out.txt"
    both = threading.Barrier(2, timeout=30)
    names = []

    def work(text: str) -> None:
        with complete_or_absent(target) as partial:
            partial.write_text(text)
            names.append(partial)
            both.wait()
            assert partial.read_text() == text

    threads = [threading.Thread(target=work, args=(text,)) for text in ("one", "two")]
    for each in threads:
        each.start()
    for each in threads:
        each.join()
    assert len(set(names)) == 2
    assert target.read_text() in ("one", "two")
    assert list(tmp_path.iterdir()) == [target]

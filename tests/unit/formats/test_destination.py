"""Outputs: plain files are replaced, links followed, pipes and devices written into, all else refused."""

import os
import pty
import socket
import stat
import threading
from pathlib import Path

import pytest

from creak.errors import WriteError
from creak.formats.complete_file import complete_file, write_text
from creak.formats.destination import descriptor_of, destination
from helpers_disk import FULL, NULL, device
from helpers_refusal import refusal


def refused(path, **words) -> str:
    return str(refusal(destination, path, **words))


def test_a_device_stays_what_it_is(tmp_path):
    null = device(tmp_path / "null", NULL)
    write_text(null, "words")
    with complete_file(null) as partial:
        partial.write_text("more")
    assert stat.S_ISCHR(null.lstat().st_mode)
    assert list(tmp_path.iterdir()) == [null]


def test_a_device_that_is_full_ends_in_one_message(tmp_path):
    full = device(tmp_path / "full", FULL)
    with pytest.raises(WriteError, match=r"cannot write .*full: no space left on device$"):
        write_text(full, "words")
    assert stat.S_ISCHR(full.lstat().st_mode)


def test_a_terminal_shows_what_is_written():
    main, secondary = pty.openpty()
    write_text(Path(os.ttyname(secondary)), "words\n")
    assert os.read(main, 100) == b"words\r\n"
    os.close(main)
    os.close(secondary)


def test_a_pipe_gets_all_of_it(tmp_path):
    pipe, got = tmp_path / "pipe", []
    os.mkfifo(pipe)
    reader = threading.Thread(target=lambda: got.append(pipe.read_text()), daemon=True)
    reader.start()
    write_text(pipe, "line\n" * 50_000)
    reader.join(20.0)
    assert got == ["line\n" * 50_000]
    assert stat.S_ISFIFO(pipe.lstat().st_mode)
    assert list(tmp_path.iterdir()) == [pipe]


def test_a_failure_leaves_a_pipe_alone(tmp_path):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    with pytest.raises(RuntimeError, match="midway"), complete_file(pipe):
        raise RuntimeError("midway")  # nobody reads: opening it would wait for ever
    assert stat.S_ISFIFO(pipe.lstat().st_mode)


def test_what_is_no_stream_does_not_go_into_a_pipe(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    assert "it is a pipe; expected a file" in refused(tmp_path / "pipe", stream=False)
    assert "it is a device; expected a file" in refused(device(tmp_path / "null", NULL), stream=False)


def test_other_nodes_are_refused(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # names of sockets are short
    with socket.socket(socket.AF_UNIX) as server:
        server.bind("socket")
        assert "it is a socket; expected a file" in refused(tmp_path / "socket")
    assert "it is a folder" in refused(tmp_path)
    (tmp_path / "round").symlink_to("round")
    assert "too many levels of symbolic links" in refused(tmp_path / "round")
    (tmp_path / "file").write_text("")
    assert "not a directory" in refused(tmp_path / "file" / "below")


def test_a_block_device_is_refused(tmp_path):
    block = device(tmp_path / "block", os.makedev(250, 250), stat.S_IFBLK)
    assert "it is a block device" in refused(block)


def test_a_link_stays_and_its_file_is_replaced(tmp_path):
    (tmp_path / "far").mkdir()
    target, link, again = tmp_path / "far" / "target", tmp_path / "link", tmp_path / "again"
    target.write_text("old")
    link.symlink_to("far/target")
    again.symlink_to(link)
    write_text(again, "new")
    assert link.is_symlink()
    assert again.is_symlink()
    assert target.read_text() == "new"
    assert sorted(p.name for p in tmp_path.iterdir()) == ["again", "far", "link"]
    assert list(target.parent.iterdir()) == [target]


def test_a_link_to_nothing_makes_its_file(tmp_path):
    (tmp_path / "link").symlink_to("made")
    write_text(tmp_path / "link", "new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "made").read_text() == "new"


def test_open_files_of_this_process_are_known(tmp_path):
    assert descriptor_of(Path("/dev/stdout")) == 1
    assert descriptor_of(Path("/dev/fd/7")) == 7
    assert descriptor_of(Path(f"/proc/{os.getpid()}/fd/2")) == 2
    assert descriptor_of(tmp_path / "fd" / "1") is None
    link = tmp_path / "link"
    link.symlink_to("/dev/stdout")
    assert descriptor_of(link) == 1


def test_an_open_file_is_written_on_not_replaced(tmp_path):
    with (tmp_path / "log").open("w+b") as log:
        log.write(b"before\n")
        log.flush()
        write_text(Path(f"/dev/fd/{log.fileno()}"), "words\n")
        log.write(b"after\n")
    assert (tmp_path / "log").read_text() == "before\nwords\nafter\n"

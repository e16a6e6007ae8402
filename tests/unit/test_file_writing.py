"""Files are written whole or not at all, whatever writes them."""

import io
import os
import zlib
from pathlib import Path

import pytest
from matplotlib.animation import HTMLWriter

import frictionlab as fl
from frictionlab.file_writing import replace_file, write_file, write_text

FULL = OSError(28, "No space left on device")


@pytest.fixture(scope="module")
def run():
    return fl.simulate(fl.MassOnBelt(), 0.5, progress=False)


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def write_on_a_full_disk(path, tidy_up=lambda: None):
    """What comes after some bytes were written."""
    with write_file(path) as beside, open(beside, "wb") as stream:
        stream.write(b"half of it")
        try:
            raise FULL
        finally:
            tidy_up()


def test_a_file_is_replaced_whole(tmp_path):
    path = tmp_path / "notes.txt"
    path.write_text("old")
    path.chmod(0o640)
    with write_file(path) as beside:
        beside.write_text("new")
        assert beside.name == path.name
        assert path.read_text() == "old"
    assert contents(tmp_path) == {"notes.txt": b"new"}
    assert path.stat().st_mode & 0o777 == 0o640


def test_where_writing_fails_the_old_file_stays(tmp_path):
    path = write_text(tmp_path / "notes.txt", "old")
    with pytest.raises(OSError, match="No space left on device: give another path, or make room") as caught:
        write_on_a_full_disk(path)
    assert caught.value.filename == str(path)
    assert contents(tmp_path) == {"notes.txt": b"old"}


def test_an_error_that_hides_a_full_disk_tells_of_it(tmp_path):
    """As the compressor of a PDF does, which is closed after the disk was full."""
    with pytest.raises(OSError, match="No space left on device: give another path"):
        write_on_a_full_disk(tmp_path / "picture.pdf", lambda: zlib.decompress(b"no such data"))
    assert contents(tmp_path) == {}


def test_other_errors_stay_what_they_are(tmp_path):
    with pytest.raises(ZeroDivisionError), write_file(tmp_path / "notes.txt"):
        raise ZeroDivisionError
    assert contents(tmp_path) == {}


def test_a_suffix_that_a_writer_adds_is_kept(run, tmp_path):
    run.plot().figure.savefig(tmp_path / "picture")
    assert list(contents(tmp_path)) == ["picture.png"]


def test_a_link_stays_a_link(tmp_path):
    path, link = write_text(tmp_path / "notes.txt", "old"), tmp_path / "link.txt"
    link.symlink_to(path)
    write_text(link, "new")
    assert link.is_symlink()
    assert path.read_text() == "new"


@pytest.mark.parametrize(
    ("name", "cure"), [("", "give another path, or make room"), ("missing/notes.txt", "make its folder")]
)
def test_what_is_no_place_for_a_file_is_named(name, cure, tmp_path):
    with pytest.raises(OSError, match=cure) as caught:
        write_text(tmp_path / name, "text")
    assert caught.value.filename == str(tmp_path / name)
    assert contents(tmp_path) == {}


def test_streams_and_devices_are_written_as_they_are():
    stream = io.StringIO()
    with replace_file(stream) as same:
        assert same is stream
    with replace_file(os.devnull) as same:
        assert same == os.devnull


WRITERS = {
    "picture.png": lambda run, path: run.plot().figure.savefig(path),
    "picture.svg": lambda run, path: run.plot().figure.savefig(str(path)),
    "film.gif": lambda run, path: fl.animate(run, fps=1.0, speed=0.05).save(path, writer="pillow", dpi=30),
    "sound.wav": lambda run, path: fl.listen(run, window=(0.0, 0.5)).save(path),
    "run.npz": lambda run, path: run.save(path),
}


@pytest.mark.parametrize("name", WRITERS)
def test_what_the_package_writes_takes_the_place_of_the_old_file_at_its_end(name, run, tmp_path, monkeypatch):
    path = tmp_path / name
    path.write_bytes(b"old")
    before, replaced = os.replace, []

    def replace(source, target):
        if Path(target).parent == tmp_path:  # not what is kept in a cache folder meanwhile
            replaced.append((Path(target), path.read_bytes()))
        before(source, target)

    monkeypatch.setattr(os, "replace", replace)
    WRITERS[name](run, path)
    assert replaced == [(path, b"old")]
    assert list(contents(tmp_path)) == [name]
    assert path.stat().st_size > len(b"old")


@pytest.mark.slow
def test_a_film_of_pages_by_a_writer_of_ones_own_may_keep_its_frames_beside(run, tmp_path):
    writer = HTMLWriter(fps=1.0)
    fl.animate(run, fps=1.0, speed=0.05).save(tmp_path / "film.html", writer=writer, dpi=30)
    assert {path.name for path in tmp_path.iterdir()} == {"film.html", "film_frames"}
    assert all(contents(tmp_path / "film_frames").values())

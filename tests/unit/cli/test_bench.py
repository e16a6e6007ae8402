"""The command `frictionlab bench`, without its measurements."""

import json

from frictionlab.bench import harness
from frictionlab.cli import command


def test_scenes_that_are_done_are_in_the_file_when_it_is_stopped(tmp_path, monkeypatch, capsys):
    def measure(scene, repeats):
        if scene.name == "B":
            raise KeyboardInterrupt
        return [harness.WorkPrecisionRow(scene.name, "exact", harness.BASE_METHOD, 1.0, 1e-15, 3, 0, 10)]

    monkeypatch.setattr(harness, "measure", measure)
    path = tmp_path / "bench.json"
    assert command.main(["bench", "--scene", "A", "--scene", "B", "--json", str(path)]) == 130
    assert [row["scene"] for row in json.loads(path.read_text())] == ["A"]
    assert "A:" in capsys.readouterr().out

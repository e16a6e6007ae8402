"""`frictionlab animate` and `frictionlab sound`: the files are those of the run."""

import json

import numpy as np
import pytest
from PIL import Image
from scipy.io import wavfile

import frictionlab as fl
from frictionlab.cli.command import main


@pytest.mark.slow
def test_a_film_has_the_frames_that_were_asked_for(tmp_path, capsys):
    file = tmp_path / "ball.gif"
    words = ["--model", "BouncingBall", "--t-end", "1", "--window", "0.5", "--speed", "0.5", "--fps", "6"]
    assert main(["animate", *words, "-o", str(file), "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["file"] == str(file)
    with Image.open(file) as image:
        assert image.n_frames == 7  # a second with six frames, and the last instant
        assert image.info["duration"] in (160, 170)


def test_a_sound_has_the_samples_of_the_run(tmp_path, capsys):
    file = tmp_path / "slider.wav"
    words = ["--set", "mu_k=1.2", "--t-end", "2", "--signal", "friction_force", "-q"]
    assert main(["sound", *words, "-o", str(file)]) == 0
    assert capsys.readouterr().out == f"wrote {file}\n"
    run = fl.simulate(fl.SliderOnBelt(mu_k=1.2), 2.0, progress=False)
    expected = fl.listen(run, "friction_force")
    rate, samples = wavfile.read(file)
    assert rate == expected.rate
    assert np.abs(samples / 32767 - expected.samples).max() < 1e-4

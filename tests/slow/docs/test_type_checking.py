"""What type checkers and editors see: the recipes for laws and models are clean, a misspelt name is not."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("pyright", reason="pyright checks the types; it is not installed")

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[3]
RECIPES = "own-law.md", "own-model.md"
CALLS = """\
import numpy as np

import frictionlab as fl

model = fl.SliderOnBelt(mu_k=1.4, F=200.0, contact=fl.LinearContact(k2=5e3), e=0.5)
fl.SliderOnBelt(mu_kk=1.4)  # wrong
fl.SliderOnBelt(friction="Coulomb")  # wrong
fl.SliderOnBelt(1.4)  # wrong
fl.MassOnBelt(v_s=0.1, friction=fl.Stribeck())
fl.MassOnBelt(v_S=0.1)  # wrong
for kind in fl.DenHartog, fl.FreeCoulomb, fl.ImpactOscillator, fl.ModeCoupling:
    kind(m=2.0)
    kind(mass=2.0)  # wrong
for other in fl.SliderOnRigidBelt, fl.BouncingBall, fl.TwoBlocks:
    other(interface=fl.SlidingOnly())
    other(interfaces=fl.SlidingOnly())  # wrong
fl.Coulomb(mu_k=0.3, mu_s=0.4)
fl.Coulomb(mu=0.3)  # wrong
fl.Taylor(tol=1e-10)
fl.Taylor(tolerance=1e-10)  # wrong
fl.RK4(step=1e-4)
fl.RK4(steps=1e-4)  # wrong
run = fl.simulate(model.replace(mu_k=2.0), 20.0, progress=False)
fl.simulate(model, 20.0, progres=False)  # wrong
fl.simulat(model, 20.0)  # wrong
float(run.final_state[0])
swept = fl.sweep(model, fl.eigenvalues, {"F": [100.0]}, shard=(0, 8), workers=2)
fl.sweep(model, fl.eigenvalues, {"F": [100.0]}, shards=(0, 8))  # wrong
fl.uncertainty(model, fl.GrowthRate(), {}, rng=np.random.default_rng(1))
fl.uncertainty(model, fl.GrowthRate(), {}, seed=1)  # wrong
A, B, C, D = fl.linearize(model, inputs=["y1"], outputs=["normal_force"])
fl.linearize(model, input=["y1"])  # wrong
fl.MassOnBelt(friction=fl.LuGre(sigma_0=1e3))
run.plot(color="red", linewidth=2.0)
"""


def complaints(folder, texts):
    """Lines (from 1) of each text that pyright finds an error in, at the strictness it has by itself."""
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")
    settings = {"pythonVersion": "3.11", "extraPaths": [str(ROOT)], "typeCheckingMode": "standard"}
    (folder / "pyrightconfig.json").write_text(json.dumps(settings), encoding="utf-8")
    command = [sys.executable, "-m", "pyright", "--outputjson", "--pythonpath", sys.executable]
    answer = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    report = json.loads(answer.stdout)
    assert report["summary"]["filesAnalyzed"] == len(texts)
    found = {name: set() for name in texts}
    for one in report["generalDiagnostics"]:
        if one["severity"] == "error":
            found[Path(one["file"]).name].add(one["range"]["start"]["line"] + 1)
    return found


def test_recipes_are_clean_and_misspelt_names_are_seen(tmp_path):
    texts = {"calls.py": CALLS}
    for page in RECIPES:
        source = (ROOT / "docs" / "how-to" / page).read_text(encoding="utf-8")
        cells = re.findall(r"^```\{code-cell\}\n(.*?)^```$", source, re.MULTILINE | re.DOTALL)
        assert any("class " in cell for cell in cells)
        texts[page.replace("-", "_").replace(".md", ".py")] = "\n\n".join(cells)
    found = complaints(tmp_path, texts)
    wrong = {i for i, line in enumerate(CALLS.splitlines(), 1) if line.endswith("# wrong")}
    assert found == {name: wrong if name == "calls.py" else set() for name in texts}

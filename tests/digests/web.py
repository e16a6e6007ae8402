"""``python -m tests.digests.web``: the same runs by the module for browsers, in node, and natively.

Times, events and states have to be equal to the last bit; the exit code is how many runs differ.  It needs
node, and the module that ``python -m frictionlab.compilation --web`` makes.
"""

from __future__ import annotations

import json
import subprocess
import sys
from importlib import resources
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from unittest.mock import patch

import numpy as np

import frictionlab as fl
from frictionlab.hybrid.chatter_limit import with_chatter_limit
from frictionlab.hybrid.methods.taylor import Taylor, is_affine
from frictionlab.hybrid.problem import Status
from frictionlab.pages import export, page_data
from frictionlab.pages.export import solver_data
from frictionlab.pages.javascript import javascript_of_formulas
from frictionlab.tape.packing import program_of
from tests.digests.runs import Case, cases

SCRIPTS = "functions", "assembler", "jets", "solver"
RUN_ALL = """
const plain = (array) => Array.from(array, Number);
loadSolver().then(async (solver) => {
  for (const { method, structure, values, state, end } of RUNS) {
    SCENE.method = method;
    bindFunctions(solver);
    structure.numbers = eval(structure.numbers);
    solver.load(structure);
    await solver.useJets(structure);
    const run = solver.run(structure, values, state, end);
    const written = structure.jets.filter((place) => place > 0n);
    console.log(JSON.stringify({
      finished: run.status === FINISHED, jets: written.length, state: run.state,
      times: plain(run.eventTimes), states: plain(run.eventStates),
    }));
  }
});
"""


def data_of(case: Case, run: Any) -> dict[str, Any]:
    """A run as node is given it; its initial state and parameters are those of the native run."""
    model, method = case.model, case.method
    found = model.automaton() if isinstance(model, fl.Model) else model
    automaton = with_chatter_limit(found, method.chatter_limit(found)).derived()
    program, _ = program_of(automaton)
    scene = {
        "states": [symbol.name for symbol in automaton.states],
        "parameters": [symbol.name for symbol in automaton.parameters],
        "modes": list(program.modes),
        "affine": bool(is_affine(program)),
        "order": method.order_of(program),
        "constants": len(program.code.ops),
        "numbers": javascript_of_formulas(program.formulas, [len(automaton.parameters)]),
        "arrays": page_data.run_arrays(program, method),
    }
    with patch.object(export, "Taylor", lambda: method):
        described = export.method_data()
    values = [float(value) for value in automaton.parameters.values()]
    start = run.raw.step_states[0].tolist()
    return {"method": described, "structure": scene, "values": values, "state": start, "end": case.t_end}


def expected(raw: Any) -> dict[str, Any]:
    """What node has to find."""
    # Not the codes of guards and modes, which are other numbers where modes are derived as runs come to them.
    numbers = {"state": raw.state, "times": raw.event_times}
    lists = {
        name: np.ravel(value).tolist() for name, value in (numbers | {"states": raw.event_states}).items()
    }
    return {"finished": raw.status is Status.FINISHED} | lists


def run_in_node(given: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """The results of node, one for each run."""
    folder = resources.files("frictionlab.pages").joinpath("scripts")
    texts = [folder.joinpath(f"{name}.js").read_text(encoding="utf-8") for name in SCRIPTS]
    data = {"SCENE": {}, "SOLVER": solver_data("".join(texts)), "RUNS": given}
    parts = [f"const {name} = {json.dumps(value)};" for name, value in data.items()] + texts
    with TemporaryDirectory() as scratch:
        script = Path(scratch) / "runs.js"
        script.write_text("\n".join([*parts, RUN_ALL]), encoding="utf-8")
        done = subprocess.run(["node", str(script)], capture_output=True, text=True, check=True)
    return [json.loads(line) for line in done.stdout.splitlines()]


def main() -> int:
    """Compare all runs by Taylor's method."""
    chosen = [case for case in cases() if isinstance(case.method, Taylor)]
    runs = [case.run() for case in chosen]
    found = run_in_node([data_of(case, run) for case, run in zip(chosen, runs, strict=True)])
    differ = 0
    for case, run, web in zip(chosen, runs, found, strict=True):
        jets = web.pop("jets")
        same = web == expected(run.raw)
        differ += not same
        counts = f"{len(run.events)} events, {jets} modes as machine code"
        print(f"{'' if same else 'DIFFERS  '}{case.name}: {counts}")
    print(f"{differ} of {len(chosen)} runs differ")
    return min(differ, 100)


if __name__ == "__main__":
    sys.exit(main())

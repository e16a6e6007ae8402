// Angles that turn are drawn modulo a turn, from -pi to pi, with ticks in multiples of pi. The rule is that of
// frictionlab/plotting/turns.py.
const TURN = 2 * Math.PI;

const withinTurn = (angle) => angle - TURN * Math.floor((angle + Math.PI) / TURN);

const doesTurn = ({ structure }, name) => structure.turning.includes(name);
const isFast = (step) => Math.abs(step) > Math.PI; // which leaves open how the angle has turned

function noteOfTurns(result, names) {
  const fast = ([...angle]) => angle.some((v, i) => isFast(v - angle[i - 1]));
  return names.some((name) => doesTurn(result, name) && fast(result.samples.column(name)))
    ? "turns too fast to be drawn: show less of the run" : "";
}

// [angles modulo a turn, what is drawn over them], cut where the angle comes to -pi or pi: with its one side, NaN and
// its other; points more than half a turn apart are not joined
function cutAtTurns(angle, other) {
  const angles = [], others = [];
  for (let i = 0, before = NaN; i < angle.length; i++) {
    const turn = Math.floor((angle[i] + Math.PI) / TURN);
    if (isFast(angle[i] - angle[i - 1])) {
      angles.push(NaN, NaN, NaN);
      others.push(NaN, NaN, NaN);
    } else if (turn !== before && Number.isFinite(turn - before)) {
      const border = TURN * Math.max(turn, before) - Math.PI,
        share = (border - angle[i - 1]) / (angle[i] - angle[i - 1]);
      const there = other[i - 1] + share * (other[i] - other[i - 1]), side = turn > before ? Math.PI : -Math.PI;
      angles.push(side, NaN, -side);
      others.push(there, there, there);
    }
    angles.push(angle[i] - TURN * turn);
    others.push(other[i]);
    before = turn;
  }
  return [Float64Array.from(angles), Float64Array.from(others)];
}

function multipleOfPi(halves) { // "−3π/2"
  if (!halves) return "0";
  const size = Math.abs(halves), [count, under] = size % 2 ? [size, "/2"] : [size / 2, ""];
  return `${halves < 0 ? "−" : ""}${count > 1 ? count : ""}π${under}`;
}

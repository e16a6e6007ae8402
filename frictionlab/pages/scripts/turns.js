// Angles that turn are drawn modulo a turn, from -pi to pi, with ticks in multiples of pi. The rule is that of
// frictionlab/plotting/turns.py.
const TURN = 2 * Math.PI;

const withinTurn = (angle) => angle - TURN * Math.floor((angle + Math.PI) / TURN);

// of an angle that is cyclic, or that goes through more than a turn
function doesTurn({ structure, samples }, name) {
  if (structure.units[name] !== "rad") return false;
  const [low, high] = dataRange([samples.column(name)]) ?? [0, 0];
  return structure.cyclic.includes(name) || high - low > TURN;
}

// [angles modulo a turn, what is drawn over them], cut where the angle comes to -pi or pi: with its one side, NaN and
// its other
function cutAtTurns(angle, other) {
  const angles = [], others = [];
  for (let i = 0, before = NaN; i < angle.length; i++) {
    const turn = Math.floor((angle[i] + Math.PI) / TURN);
    if (turn !== before && Number.isFinite(turn - before)) {
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

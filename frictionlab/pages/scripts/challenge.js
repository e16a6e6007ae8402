// A challenge: a question, what may be changed, and a goal that the result of an answer has to meet. They are data,
// of frictionlab/models/library/challenges.py.
const FREE_CONTROLS = ["window", "coordinate", "formula"]; // what is looked at, and what tells how points came to be

const challengeState = (scene, { state }) => ({ ...scene.initial, ...state });

function challengeAnswer(challenge, scene, state, result) { // {solved, text}
  const changed = differences(challengeState(scene, challenge), state).filter((name) => !FREE_CONTROLS.includes(name));
  const isParameter = (name) => scene.controls.some((about) => about.name === name && about.parameter);
  const allowed = (name) => (challenge.may.length ? challenge.may.includes(name) : isParameter(name));
  const others = changed.filter((name) => !allowed(name)),
    values = changed.map((name) => `${name} = ${shownValue(state[name])}`);
  if (others.length) return { solved: false, text: `Set ${others.join(", ")} back to where it began.` };
  if (changed.length > challenge.most) return { solved: false,
    text: `Change ${challenge.most} value at most, not ${values.join(", ")}.` };
  if (!changed.length || !meetsGoal(result, challenge.goal)) return { solved: false, text: "Not yet." };
  return { solved: true, text: `Solved: ${values.join(", ")}. The link to this setting is the proof.` };
}

function meetsGoal(result, goal) {
  const facts = {
    stable: Boolean(result.eigenvalues?.length)
      && result.eigenvalues.every(([re, im]) => re < -ROUNDING * Math.hypot(re, im)),
    vibrates: Boolean(result.moving && (motionText(result) || !result.decays)), strikes: result.struck,
      from: result.from,
  };
  return result.finished && Object.entries(goal).every(([name, value]) => facts[name] === value);
}

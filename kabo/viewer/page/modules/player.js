// Plays films: where everything is at a time, as pure functions, and the player that moves the time.
//
// A film is made of steps, one after the other. A step has segments of motion as in the plan file; where objects hang that
// a hand takes or lets go (`handovers`); and the state `after` it. Several robots may move at once, and a step may begin
// before the one before it has ended (`overlap`).

const DWELL = 0.7; // seconds for which a step without motion is shown
const FRAME = 1 / 25; // seconds of a small step
const SAME = 1e-9; // seconds

/**
 * @typedef {{robots: Object<string, Object<string, number>>, objects: Object<string, object>}} State
 * @typedef {{id: string, segments?: object[], handovers?: object[], after?: State|null, overlap?: number}} Step
 * @typedef {{start: State, steps: object[], duration: number}} Film
 */

/**
 * A film of steps, with when each begins and ends, and the state in which it begins.
 * @param {State|null} start
 * @param {Step[]} steps
 * @returns {Film}
 */
export function filmOf(start, steps) {
  const first = start ?? { robots: {}, objects: {} };
  let before = first;
  let time = 0;
  const timed = steps.map((step) => {
    const length = Math.max(0, ...(step.segments ?? []).map((segment) => segment.times.at(-1)));
    const begin = Math.max(0, time - (step.overlap ?? 0));
    const shown = { ...step, length, begin, end: begin + (length > 0 ? length : DWELL), before };
    before = merged(partly(shown, before, Infinity), step.after);
    time = shown.end;
    return shown;
  });
  return { start: first, steps: timed, duration: time, last: before };
}

/**
 * Where everything is at a time of a film: held objects hang from the hand that holds them.
 * @param {Film} film
 * @param {number} time [s] since the film's beginning
 * @returns {State}
 */
export function stateAt(film, time) {
  const running = film.steps.findIndex((step) => step.end > time + SAME);
  if (running < 0) {
    return film.last;
  }
  let state = film.steps[running].before;
  for (const step of film.steps.slice(running)) {
    if (step.begin > time + SAME) {
      break;
    }
    state = partly(step, state, time - step.begin);
  }
  return state;
}

/** The number of the step that is shown at a time: the last that has begun. */
export function stepAt(film, time) {
  let found = 0;
  film.steps.forEach((step, number) => {
    if (step.begin <= time + SAME) {
      found = number;
    }
  });
  return found;
}

/** A state, with what has happened in a step by a time of its own. */
function partly(step, before, time) {
  const robots = { ...before.robots };
  const objects = { ...before.objects };
  for (const segment of step.segments ?? []) {
    if (time + SAME >= segment.times[0]) {
      const values = valuesAt(segment, time);
      robots[segment.robot] = { ...robots[segment.robot] };
      segment.joints.forEach((joint, k) => { robots[segment.robot][joint] = values[k]; });
    }
  }
  for (const { time: when, object, parent, position, quaternion } of step.handovers ?? []) {
    if (when <= time + SAME) {
      objects[object] = { parent, position, quaternion };
    }
  }
  return { robots, objects };
}

/** The values of a segment's joints at a time: of its trajectory, or else straight between way points. */
export function valuesAt(segment, time) {
  const { times, waypoints, trajectory } = segment;
  if (time >= times.at(-1)) {
    return waypoints.at(-1);
  }
  if (trajectory) {
    const piece = spanAt(trajectory.times, time);
    const since = Math.max(0, time - trajectory.times[piece]);
    return trajectory.coefficients[piece].map((powers) => powers.reduceRight((sum, power) => sum * since + power, 0));
  }
  const low = spanAt(times, time);
  const [from, to] = [times[low], times[low + 1]];
  const share = to > from ? Math.max(0, (time - from) / (to - from)) : 1;
  return waypoints[low].map((value, k) => value + share * (waypoints[low + 1][k] - value));
}

/** The number of the last of increasing times that is not after a time; never the last one of all. */
function spanAt(times, time) {
  let low = 0;
  let high = times.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    [low, high] = times[middle] <= time ? [middle, high] : [low, middle];
  }
  return low;
}

/** A state, with a change applied to it. */
export function merged(state, change) {
  if (!change) {
    return state;
  }
  const robots = { ...state.robots };
  for (const [name, joints] of Object.entries(change.robots ?? {})) {
    robots[name] = { ...robots[name], ...joints };
  }
  return { robots, objects: { ...state.objects, ...change.objects } };
}

/** Moves the time of a film, and tells who listens. */
export class Player {
  constructor() {
    this.film = filmOf(null, []);
    this.time = 0;
    this.speed = 1;
    this.playing = false;
    this.listeners = [];
  }

  /** Calls `f(player)` whenever the time, the film or playing changes. */
  onChange(f) {
    this.listeners.push(f);
  }

  tell() {
    this.listeners.forEach((f) => f(this));
  }

  /** Shows another film from a time on. */
  load(film, time = 0) {
    this.film = film;
    this.scrub(time);
  }

  get state() {
    return stateAt(this.film, this.time);
  }

  /** Where everything is at another time. */
  stateAt(time) {
    return stateAt(this.film, time);
  }

  /** The number of the step that is shown. */
  get number() {
    return stepAt(this.film, this.time);
  }

  /** The step that is shown. */
  get step() {
    return this.film.steps[this.number];
  }

  /** The time within the step that is shown. */
  get local() {
    const step = this.step;
    return step ? Math.min(step.length, Math.max(0, this.time - step.begin)) : 0;
  }

  scrub(time) {
    this.time = Math.min(this.film.duration, Math.max(0, time));
    this.tell();
  }

  play() {
    if (this.playing || this.film.duration === 0) {
      return;
    }
    if (this.time >= this.film.duration - SAME) {
      this.time = 0;
    }
    this.playing = true;
    let last = performance.now();
    const onward = (now) => {
      if (!this.playing) {
        return;
      }
      const next = this.time + (Math.max(0, now - last) / 1000) * this.speed;
      last = now;
      if (next >= this.film.duration) {
        this.playing = false;
      }
      this.scrub(next);
      if (this.playing) {
        requestAnimationFrame(onward);
      }
    };
    requestAnimationFrame(onward);
    this.tell();
  }

  pause() {
    this.playing = false;
    this.tell();
  }

  toggle() {
    if (this.playing) {
      this.pause();
    } else {
      this.play();
    }
  }

  setSpeed(speed) {
    this.speed = speed;
    this.tell();
  }

  /** Goes to the beginning of the next step (1), or of this one and then those before it (-1). */
  go(by) {
    this.playing = false;
    const { steps, duration } = this.film;
    if (by > 0) {
      this.scrub(steps[this.number + 1]?.begin ?? duration);
    } else {
      const here = this.step;
      this.scrub(here && this.time > here.begin + SAME ? here.begin : steps[this.number - 1]?.begin ?? 0);
    }
  }

  /** Goes a 25th of a second on or back. */
  nudge(by) {
    this.playing = false;
    this.scrub(this.time + by * FRAME);
  }
}

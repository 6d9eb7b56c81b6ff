// What the messages tell of one mission, step by step.

const NAV = {MOVING: 0, REACHED: 1, FAILED: 2, STOPPED: 3};

class Mission {
  constructor() {
    this.told = null;        // the newest MISSION message
    this.task = null;        // the newest TASK message that came in while it ran
    this.images = new Map(); // by utime
    this.byNumber = new Map();
  }

  add({channel, message}) {
    const step = () => this.step(message.step);
    switch (channel) {
      case 'SECONDLOOK_MISSION': this.told = message; break;
      case 'SECONDLOOK_TASK': this.task = message; break;
      case 'SECONDLOOK_IMAGE': if (message.images.length) this.images.set(message.utime, message.images[0]); break;
      case 'SECONDLOOK_PLANE': step().plane = message; break;
      case 'SECONDLOOK_LOOK': step().look = message; break;
      case 'SECONDLOOK_NAV_STATUS': step().way.push(message); break;
      case 'SECONDLOOK_TIMING': step().stages.push(...message.stages); break;
      case 'SECONDLOOK_VIEW': collect(step(), 'view', message, 'detections'); break;
      case 'SECONDLOOK_OBJECTS': collect(step(), 'belief', message, 'objects'); break;
      case 'SECONDLOOK_CANDIDATES': collect(step(), 'choice', message, 'looks'); break;
      case 'SECONDLOOK_OCCUPANCY': collect(step(), 'map', message, 'blocks'); break;
    }
  }

  step(number) {
    if (!this.byNumber.has(number)) {
      this.byNumber.set(number, {
        number, view: null, plane: null, belief: null, choice: null, map: null, look: null, way: [], stages: [], messages: 0,
      });
    }
    const step = this.byNumber.get(number);
    ++step.messages;
    return step;
  }

  get steps() { return [...this.byNumber.values()].sort((a, b) => a.number - b.number); }

  get ended() { return this.told !== null && this.told.end !== ''; }

  // Of what matters on the table, as it was believed after `step`, or now.
  objects(step = Infinity) {
    const believed = this.steps.filter(s => s.belief && s.number <= step).at(-1);
    return believed ? believed.belief.objects.filter(o => o.state !== 'rejected') : [];
  }

  plane(step = Infinity) { return this.steps.filter(s => s.plane && s.number <= step).at(-1)?.plane ?? null; }

  image(step) { return step.view ? this.images.get(step.view.utime) ?? null : null; }

  // Robot time since the mission began [s].
  seconds(utime) {
    if (!this.told) return NaN;
    const total = this.told.end === '' ? 0 : this.told.total_seconds;
    return (utime - this.told.utime) / 1e6 + total;
  }

  // The confidence that `name` needs to be called found.
  needed(name) {
    const task = this.task ?? this.told?.task;
    return task?.wanted.find(w => w.name === name)?.confidence ?? task?.confidence ?? NaN;
  }

  // What was driven and how long it took, from the end's figures or what came last.
  costs() {
    const looks = this.steps.filter(s => s.look).length;
    if (this.ended) return {looks, metres: this.told.metres, seconds: this.told.total_seconds};
    const last = this.steps.flatMap(s => s.way).at(-1);
    return {looks, metres: last?.metres ?? 0, seconds: last ? this.seconds(last.utime) : 0};
  }
}

// A message in pieces becomes one with the whole list.
function collect(step, key, message, list) {
  if (message.piece === 0 || !step[key]) step[key] = {...message, [list]: []};
  step[key][list].push(...message[list]);
}

// verified, unknown or open: what an object's state means to a reader.
function standing(object) {
  if (['verified', 'classified', 'modelled'].includes(object.state)) return 'verified';
  return object.state === 'unknown' ? 'unknown' : 'open';
}

function nameOf(object) {
  if (!object) return '?';
  const kind = standing(object);
  if (kind === 'unknown') return 'unknown';
  if (kind === 'verified') return object.class_name;
  return object.class_name ? `${object.class_name}?` : '?';
}

function probability(object, name) {
  return object.posterior.find(p => p.name === name)?.probability ?? 0;
}

function confidence(object) {
  return object.class_name ? probability(object, object.class_name) : NaN;
}

// A look's check that refused it, in a word or two.
function refusal(look) {
  const reason = look.reason.split(':')[0].trim();
  return reason || 'refused';
}

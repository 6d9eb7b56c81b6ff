// How the belief in each object moved, and by what evidence.

const COURSES = ['var(--look)', 'var(--stage-2)', 'var(--stage-1)', 'var(--fault)'];

function drawBeliefs(mission, ui) {
  const objects = mission.objects();
  if (objects.length === 0) return [];
  const steps = mission.steps.filter(step => step.belief);
  return [
    el('h2', {}, 'How the belief moved'),
    el('p', {class: 'note'}, 'The probability of each class after each view, by step. A dot: that view shows the object. Dashed: what the class needs.'),
    el('div', {class: 'beliefs'}, objects.map(object => drawBelief(mission, object, steps, ui.step))),
  ];
}

function drawBelief(mission, object, steps, selected) {
  const past = steps.map(step => ({step, object: step.belief.objects.find(o => o.id === object.id)})).filter(p => p.object);
  const names = leadingClasses(past);
  const color = name => name === 'unknown' ? 'var(--unknown)' : COURSES[names.filter(n => n !== 'unknown').indexOf(name) % COURSES.length];
  return el('article', {class: 'belief'},
    el('h3', {}, `Object ${object.id}: `, el('span', {class: `state ${standing(object)}`}, nameOf(object))),
    drawCourses(mission, object, past, steps, names, color, selected),
    el('div', {class: 'keys'}, names.map(name => el('span', {},
      el('span', {class: 'key', style: `background: ${color(name)}`}), `${name} ${fixed(probability(object, name))}`))),
    el('p', {class: 'note'}, object.reason),
    drawEvidence(object));
}

// The classes that were ever believed in, up to four, and "unknown".
function leadingClasses(past) {
  const highest = new Map();
  for (const {object} of past) {
    for (const {name, probability: p} of object.posterior) highest.set(name, Math.max(p, highest.get(name) ?? 0));
  }
  const known = [...highest].filter(([name, p]) => name !== 'unknown' && p >= 0.03).sort((a, b) => b[1] - a[1]).slice(0, COURSES.length);
  return [...known.map(([name]) => name), ...(highest.has('unknown') ? ['unknown'] : [])];
}

function drawCourses(mission, object, past, steps, names, color, selected) {
  const width = 300, height = 132, left = 24, right = 8, top = 8, bottom = 18;
  const first = steps[0].number, last = Math.max(steps.at(-1).number, first + 1);
  const x = number => left + (width - left - right) * (number - first) / (last - first);
  const y = p => top + (height - top - bottom) * (1 - p);
  const seen = step => step.view?.detections.some(d => d.object_id === object.id);
  const needed = mission.needed(object.class_name);
  const every = Math.ceil(steps.length / 10);
  return el('svg', {viewBox: `0 0 ${width} ${height}`, role: 'img', 'aria-label': `Belief in object ${object.id} by step: ${names.map(n => `${n} ${fixed(probability(object, n))}`).join(', ')} in the end`},
    [0, 0.5, 1].map(p => [
      el('line', {class: 'axis', x1: left, x2: width - right, y1: y(p), y2: y(p)}),
      el('text', {x: left - 5, y: y(p) + 3.5, 'text-anchor': 'end'}, `${p}`)]),
    steps.map((step, i) => i % every ? null : el('text', {x: x(step.number), y: height - 4, 'text-anchor': 'middle'}, `${step.number}`)),
    selected >= first && selected <= last ? el('line', {class: 'now', x1: x(selected), x2: x(selected), y1: top, y2: height - bottom}) : null,
    Number.isFinite(needed) && standing(object) !== 'unknown' ? el('line', {class: 'needed', x1: left, x2: width - right, y1: y(needed), y2: y(needed)}) : null,
    [...names].reverse().map(name => {
      const points = past.map(p => [x(p.step.number), y(probability(p.object, name))].map(v => v.toFixed(1)));
      return el('g', {style: `stroke: ${color(name)}; fill: ${color(name)}`},
        el('polyline', {class: 'course', points: points.map(p => p.join()).join(' ')}),
        past.map((p, i) => seen(p.step) || past.length === 1 ? el('circle', {cx: points[i][0], cy: points[i][1], r: 3}) : null));
    }));
}

function drawEvidence(object) {
  const shown = object.hypotheses.slice(0, 4).filter(h => h.evidence.length || h.struck);
  if (shown.length === 0) return null;
  return folded(`evidence ${object.id}`, `By what evidence (${plural(object.hypotheses.length, 'hypothesis', 'hypotheses')})`, {},
    shown.map(h => table(`${h.model}: support ${fixed(h.support)}${h.struck ? `; struck: ${h.reason}` : ''}`, [
      {head: 'View', class: 'number', of: e => `${e.view}`},
      {head: 'Score', class: 'number', of: e => fixed(e.score)},
      ...VERIFICATION.map(column => ({...column, of: e => column.of(e.verification)})),
      {head: 'Verdict', class: 'words', of: e => verdict(e.verification)},
    ], h.evidence)));
}

// One step of the mission: what was seen, from where, and what was done next.

function drawStrip(mission, selected, select) {
  return el('ol', {class: 'strip', 'aria-label': 'Steps'}, mission.steps.map(step => {
    const image = mission.image(step);
    const what = step.look ? whatFor(step.look) : 'the end';
    return el('li', {}, el('button', {
      type: 'button', 'data-key': `step ${step.number}`, 'aria-current': step.number === selected ? 'true' : null,
      click: () => select(step.number),
    },
    el('span', {class: 'frame'}, image ? picture(image, `View in step ${step.number}`) : 'no view'),
    `${step.number}: ${what}`));
  }));
}

function whatFor(look) {
  if (look.kind === 'search') return 'searches';
  return look.target >= 0 ? `for object ${look.target}` : 'for hidden space';
}

function picture(image, alt) {
  return el('img', {src: `data:image/jpeg;base64,${image.data}`, width: image.width, height: image.height, alt});
}

function drawStep(mission, step, ui) {
  return el('article', {class: 'step', 'aria-label': `Step ${step.number}`},
    el('div', {class: 'seen'}, drawPicture(mission, step), el('h3', {}, `Step ${step.number}`), stepInWords(mission, step)),
    el('div', {class: 'plan'}, drawPlan(mission, step, ui)),
    el('div', {class: 'more'}, drawDetections(mission, step), drawCandidates(step)));
}

function stepInWords(mission, step) {
  const sentences = [];
  if (step.view) {
    const at = mission.seconds(step.view.utime);
    const when = Number.isFinite(at) ? `After ${fixed(at, 1)} s: ` : '';
    if (step.view.index < 0) {
      sentences.push(`${when}nothing was learned from this view: ${step.view.reason}.`);
    } else {
      const objects = mission.objects(step.number);
      const count = kind => objects.filter(o => standing(o) === kind).length;
      sentences.push(`${when}view ${step.view.index} shows ${plural(step.view.detections.length, 'thing')}. ` +
        `Of ${plural(objects.length, 'object')} known by then, ${count('verified')} verified, ${count('unknown')} unknown, ${count('open')} open.`);
    }
  } else {
    sentences.push('No view was taken: nothing was known yet.');
  }
  if (step.look) {
    const end = step.way.find(status => status.phase !== NAV.MOVING);
    const outcome = !end ? 'is on its way' : end.phase === NAV.REACHED ? 'got there' : `did not get there: ${end.reason}`;
    sentences.push(` Then it took a look ${whatFor(step.look)} (${step.look.reason}) and ${outcome}.`);
  } else if (mission.ended && step === mission.steps.at(-1)) {
    sentences.push(` No look followed: ${mission.told.end}.`);
  }
  return el('p', {}, sentences.join(''));
}

function drawPicture(mission, step) {
  const image = mission.image(step);
  if (!image) return el('div', {class: 'none'}, step.view ? 'The picture of this view was not told.' : 'There is no picture of this step.');
  const objects = mission.objects(step.number);
  const labels = placeLabels(step.view.detections.map(detection => {
    const object = objects.find(o => o.id === detection.object_id);
    return {text: `${object?.id ?? '–'} ${nameOf(object)}`, kind: object ? standing(object) : 'open', contour: detection.contour};
  }), image);
  const things = step.view.detections.map((detection, i) => {
    const object = objects.find(o => o.id === detection.object_id);
    const outline = detection.contour.map(p => p.join(',')).join(' ');
    const show = () => unfold(detectionKey(step, i));
    return el('g', {
      class: `thing ${object ? standing(object) : 'open'}`, role: 'button', tabindex: 0, 'data-key': `thing ${step.number} ${i}`,
      'aria-label': `Object ${labels[i].text}: show what this view says of it`, click: show,
      keydown: event => { if (event.key === 'Enter' || event.key === ' ') { event.preventDefault(); show(); } },
    },
    el('polygon', {class: 'edge', points: outline}), el('polygon', {points: outline}));
  });
  const names = labels.map(label => label.contour.length === 0 ? null : el('g', {class: `thing ${label.kind}`, 'aria-hidden': 'true'},
    label.away ? el('line', {x1: label.foot[0], y1: label.y + 3, x2: label.foot[0], y2: label.foot[1]}) : null,
    el('text', {x: label.x, y: label.y}, label.text)));
  return el('div', {class: 'picture'}, picture(image, `What the camera saw in step ${step.number}`),
    el('svg', {viewBox: `0 0 ${image.width} ${image.height}`}, things, names));
}

// Where labels stand: above their outlines or below, further out where another one stands already.
// One that is `away` from its outline needs a line to its `foot`.
function placeLabels(labels, image) {
  const height = 14, letter = 6.9, placed = [];
  const overlaps = (a, b) => a.x < b.x + b.width && b.x < a.x + a.width && Math.abs(a.y - b.y) < height;
  for (const label of labels) {
    const xs = label.contour.map(p => p[0]), ys = label.contour.map(p => p[1]);
    const width = letter * label.text.length;
    const x = Math.max(3, Math.min((Math.min(...xs) + Math.max(...xs) - width) / 2, image.width - width));
    const above = Math.max(height, Math.min(...ys) - 6), below = Math.max(...ys) + height + 2;
    const foot = [(Math.min(...xs) + Math.max(...xs)) / 2, Math.min(...ys)];
    const row = i => above - i * height;
    const heights = [row(0), row(1), row(2), below, row(3), below + height, ...Array.from({length: 12}, (_, i) => row(i + 4))];
    const free = heights.map(y => ({...label, x, y, width, foot, away: y < above}))
      .find(spot => spot.y >= height && spot.y < image.height && !placed.some(other => overlaps(spot, other)));
    placed.push(free ?? {...label, x, y: above, width, foot, away: false});
  }
  return placed;
}

// Opens what is folded under `key` and shows it.
function unfold(key) {
  const details = document.querySelector(`details[data-key="${CSS.escape(key)}"]`);
  for (let outer = details; outer; outer = outer.parentElement.closest('details')) outer.open = true;
  details?.scrollIntoView({block: 'nearest'});
  details?.querySelector('summary').focus();
}

const detectionKey = (step, i) => `detection ${step.number} ${i}`;

function verdict(verification) {
  return verification.accepted ? 'accepted' : verification.reason;
}

const VERIFICATION = [
  {head: 'q_h', class: 'number', of: v => fixed(v.quality)},
  {head: 'Visible', class: 'number', of: v => percent(v.visible_fraction)},
  {head: 'Colour', class: 'number', of: v => fixed(v.color_agreement)},
];

function drawDetections(mission, step) {
  if (!step.view || step.view.detections.length === 0) return null;
  const objects = mission.objects(step.number);
  return folded(`detections ${step.number}`, `What this view says of each thing (${step.view.detections.length})`, {class: 'folded'},
    el('p', {class: 'note'}, 'q_h is how well the rendered model and the measured depth agree; visible is the share of the model that nothing nearer hides.'),
    step.view.detections.map((detection, i) => {
      const object = objects.find(o => o.id === detection.object_id);
      const best = detection.hypotheses[0];
      const head = `Object ${detection.object_id >= 0 ? detection.object_id : '–'}: ` +
        (best ? `${best.model} at ${fixed(best.score)}, ${best.verification.accepted ? 'accepted' : 'not accepted'}` : 'no hypothesis');
      return folded(detectionKey(step, i), head, {},
        el('p', {class: 'note'}, `${plural(detection.points, 'pixel')} with depth${detection.touches_border ? ', cut off by the edge of the image' : ''}. `,
          detection.reason ? `Nothing is accepted: ${detection.reason}. ` : '',
          object ? `Believed after this view: ${standing(object)}: ${object.reason}.` : ''),
        detection.hypotheses.length === 0 ? null : el('div', {class: 'wide'}, table('', [
          {head: 'Model', class: 'name', of: h => h.model},
          {head: 'Score', class: 'number', of: h => fixed(h.score)},
          ...VERIFICATION.map(column => ({...column, of: h => column.of(h.verification)})),
          {head: 'Verdict', class: 'words', of: h => verdict(h.verification)},
        ], detection.hypotheses)));
    }));
}

// How many of `things` fall under each name, most first: "12 path, 3 collision".
function counted(names) {
  const counts = new Map();
  for (const name of names) counts.set(name, (counts.get(name) ?? 0) + 1);
  return [...counts].sort((a, b) => b[1] - a[1]).map(([name, count]) => `${count} ${name}`);
}

function byScore(looks) {
  const rank = look => look.chosen ? Infinity : look.feasible ? look.score : -Infinity;
  return [...looks].sort((a, b) => rank(a) === rank(b) ? 0 : rank(b) - rank(a));
}

function term(look, name) {
  return look.terms?.find(t => t.name === name)?.value ?? NaN;
}

function drawCandidates(step) {
  if (!step.choice || step.choice.looks.length === 0) return null;
  const looks = step.choice.looks;
  const refused = looks.filter(look => !look.feasible);
  const why = refused.length ? `, ${refused.length} refused (${counted(refused.map(refusal)).join(', ')})` : '';
  return folded(`candidates ${step.number}`, `The looks it chose from: ${looks.length - refused.length} possible${why}`, {class: 'folded'},
    el('div', {class: 'scroll', tabindex: 0, role: 'region', 'aria-label': 'Candidate looks', 'data-key': `looks ${step.number}`}, table('', [
      {head: 'For', class: 'name', of: l => l.target >= 0 ? `object ${l.target}` : 'hidden space'},
      {head: 'Base at x, y [m]', class: 'number', of: l => point(l.X_WB.slice(0, 2))},
      {head: 'Score', class: 'number', of: l => l.feasible ? fixed(l.score, 4) : ''},
      {head: 'Gain', class: 'number', of: l => l.feasible ? fixed(term(l, 'gain'), 3) : ''},
      {head: 'Sees', class: 'number', of: l => l.feasible ? percent(term(l, 'visibility')) : ''},
      {head: 'Takes [s]', class: 'number', of: l => l.feasible ? fixed(l.seconds, 1) : ''},
      {head: 'Way [m]', class: 'number', of: l => l.feasible ? fixed(l.metres, 1) : ''},
      {head: '', class: 'state', mark: l => l.chosen ? 'verified' : l.feasible ? '' : 'open', of: l => l.chosen ? 'taken' : l.feasible ? '' : 'refused'},
      {head: 'Why', class: 'words', of: l => l.reason},
    ], byScore(looks))));
}

// The table and what is around it, from above: x to the right, y up, in W. Drawn in centimetres.

const cm = metres => Math.round(1000 * metres) / 10;
const at = (x, y) => `${cm(x)} ${cm(-y)}`;

function drawPlan(mission, step, ui) {
  const box = planBox(mission);
  if (!box) return [el('div', {class: 'none'}, 'Nothing has been told of where things are.')];
  const width = box.right - box.left;
  const unit = cm(width) / 560; // of about a pixel
  const looks = step.choice ? byScore(step.choice.looks) : [];
  const said = el('p', {class: 'said note', 'aria-live': 'polite'}, 'Point at a mark, or choose one with the arrow keys, to read about that look.');
  const svg = el('svg', {
    viewBox: `${at(box.left, box.top)} ${cm(width)} ${cm(box.top - box.bottom)}`, role: 'group', 'aria-label': `Plan of step ${step.number}`,
  },
  drawGrid(box, unit), ...drawGround(mission, step, unit),
  drawObjectsFromAbove(mission, step, unit), drawWay(mission, step, unit),
  drawMarks(looks, step, unit, said), drawRobot(mission, step, unit));
  return [svg, drawLegend(), said];
}

// What all steps' plans have to show, so that they can be compared.
function planBox(mission) {
  const points = [];
  for (const step of mission.steps) {
    if (step.plane) points.push(...step.plane.corners_W);
    for (const look of step.choice?.looks ?? []) points.push(look.X_WB);
    for (const status of step.way) points.push(status.X_WB);
    if (step.view) points.push(step.view.X_WC.p);
  }
  const finite = points.filter(p => Number.isFinite(p[0]) && Number.isFinite(p[1]));
  if (finite.length === 0) return null;
  const margin = 0.25;
  const xs = finite.map(p => p[0]), ys = finite.map(p => p[1]);
  return {
    left: Math.min(...xs) - margin, right: Math.max(...xs) + margin,
    bottom: Math.min(...ys) - margin, top: Math.max(...ys) + margin,
  };
}

function drawGrid(box, unit) {
  const lines = [];
  for (let x = Math.ceil(box.left); x <= box.right; ++x) lines.push(`M${at(x, box.top)}L${at(x, box.bottom)}`);
  for (let y = Math.ceil(box.bottom); y <= box.top; ++y) lines.push(`M${at(box.left, y)}L${at(box.right, y)}`);
  return el('path', {class: 'grid', d: lines.join(''), 'stroke-width': unit});
}

// What is lower than this is the floor [m].
const FLOOR = 0.1;

// The table and the columns of the map with something occupied in them: what reaches above the
// plane, and what is lower but no floor.
function drawGround(mission, step, unit) {
  const plane = mission.plane(step.number);
  const blocks = new Map();
  let voxel = 0;
  for (const earlier of mission.steps) {
    if (!earlier.map || earlier.number > step.number) continue;
    voxel = earlier.map.voxel_m;
    for (const block of earlier.map.blocks) blocks.set(block.index.join(), block);
  }
  const above = new Set(), below = new Set();
  for (const {index, occupied} of blocks.values()) {
    if (!occupied) continue;
    const bits = atob(occupied);
    for (let bit = 0; bit < 512; ++bit) {
      if (!(bits.charCodeAt(bit >> 3) >> (bit & 7) & 1)) continue;
      const x = 8 * index[0] + (bit & 7), y = 8 * index[1] + (bit >> 3 & 7), z = 8 * index[2] + (bit >> 6);
      if (plane && isOver(plane, voxel, x, y, z)) above.add(`${x},${y}`);
      else if (z * voxel > FLOOR) below.add(`${x},${y}`);
    }
  }
  const cells = set => [...set].map(key => {
    const [x, y] = key.split(',').map(Number);
    return `M${at(x * voxel, y * voxel)}h${cm(voxel)}v${-cm(voxel)}h${-cm(voxel)}z`;
  }).join('');
  return [
    el('path', {class: 'below', d: cells(below)}),
    plane ? el('polygon', {class: 'table', points: plane.corners_W.map(p => at(p[0], p[1])).join(' '), 'stroke-width': unit}) : null,
    el('path', {class: 'occupied', d: cells(above)}),
  ];
}

// True for a voxel that lies wholly above the plane.
function isOver(plane, voxel, x, y, z) {
  const n = plane.normal_W;
  return n[0] * (x + 0.5) * voxel + n[1] * (y + 0.5) * voxel + n[2] * z * voxel > plane.offset;
}

function drawObjectsFromAbove(mission, step, unit) {
  return mission.objects(step.number).map(object => {
    const [x, y] = object.p_WO, [w, h] = object.extent;
    return el('g', {class: standing(object)},
      el('rect', {class: 'object', x: cm(x - w / 2), y: cm(-y - h / 2), width: cm(w), height: cm(h), 'stroke-width': 1.6 * unit}),
      el('text', {x: cm(x), y: cm(-y) + 4 * unit, 'font-size': 12 * unit, 'stroke-width': 3 * unit, 'text-anchor': 'middle'}, `${object.id}`),
      el('title', {}, `Object ${object.id}: ${nameOf(object)}: ${object.reason}`));
  });
}

function drawWay(mission, step, unit) {
  const line = statuses => statuses.map((status, i) => `${i ? 'L' : 'M'}${at(status.X_WB[0], status.X_WB[1])}`).join('');
  const before = mission.steps.filter(s => s.number < step.number).flatMap(s => s.way);
  const planned = step.look?.path_W ?? [];
  return el('g', {},
    el('path', {class: 'way', d: line(before), 'stroke-width': 2.4 * unit}),
    planned.length ? el('path', {
      class: 'planned', d: planned.map((p, i) => `${i ? 'L' : 'M'}${at(p[0], p[1])}`).join(''), 'stroke-width': 1.3 * unit, 'stroke-dasharray': `${4 * unit} ${4 * unit}`,
    }) : null,
    el('path', {class: 'way now', d: line(step.way), 'stroke-width': 3 * unit}),
    step.way.filter(status => status.phase === NAV.FAILED).map(status => drawCross(status, unit)));
}

// Where a motion failed.
function drawCross({X_WB: [x, y], reason}, unit) {
  const r = 6 * unit;
  return el('path', {
    class: 'failed', 'stroke-width': 3 * unit, d: `M${at(x, y)}m${-r} ${-r}l${2 * r} ${2 * r}m0 ${-2 * r}l${-2 * r} ${2 * r}`,
  }, el('title', {}, reason));
}

// Which way a camera looks in the plan: the z axis of R_WC, by its quaternion w, x, y, z.
function heading(X_WC) {
  const [w, x, y, z] = X_WC.q;
  return Math.atan2(2 * (y * z - w * x), 2 * (x * z + w * y));
}

// A wedge at (x, y) that points along `angle`, `size` [m] long.
function wedge(x, y, angle, size, spread = 0.55) {
  const tip = (a, r) => at(x + r * Math.cos(angle + a), y + r * Math.sin(angle + a));
  return `M${tip(0, size)}L${tip(Math.PI - spread, size * 0.75)}L${tip(Math.PI + spread, size * 0.75)}z`;
}

function aim(look) {
  return look.X_WC ? heading(look.X_WC) : look.X_WB[2]; // refused ones come without the camera's pose
}

function lookInWords(look) {
  const what = look.target >= 0 ? `object ${look.target}` : 'hidden space';
  const where = `at ${what} from ${point(look.X_WB.slice(0, 2))} m`;
  if (!look.feasible) return `Look ${where}: refused: ${look.reason}`;
  const figures = `score ${fixed(look.score, 4)}, gain ${fixed(term(look, 'gain'), 3)}, sees ${percent(term(look, 'visibility'))}, ${fixed(look.seconds, 1)} s, ${fixed(look.metres, 1)} m`;
  return `${look.chosen ? 'The look that was taken, ' : 'Look '}${where}: ${figures}. ${look.reason}`;
}

function drawMarks(looks, step, unit, said) {
  const best = Math.max(1e-9, ...looks.map(look => look.score ?? 0));
  const marks = looks.map(look => el('path', {
    class: `mark${look.feasible ? '' : ' refused'}${look.chosen ? ' chosen' : ''}`,
    d: wedge(look.X_WB[0], look.X_WB[1], aim(look), (look.chosen ? 0.11 : 0.075) * unit),
    'fill-opacity': look.feasible ? fixed(0.12 + 0.88 * Math.max(0, look.score) / best) : null,
    'stroke-width': (look.chosen ? 1.8 : 0.9) * unit, 'stroke-linejoin': 'round',
  }));
  let told = -1;
  const tell = index => {
    marks[told]?.classList.remove('told');
    marks[told = index].classList.add('told');
    said.textContent = lookInWords(looks[told]);
  };
  marks.forEach((mark, i) => {
    mark.addEventListener('pointerenter', () => tell(i));
    mark.addEventListener('click', () => tell(i));
  });
  const turn = {ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1};
  return el('g', {
    tabindex: marks.length ? 0 : null, role: 'application', 'aria-label': 'Candidate looks, best first: arrow keys', 'data-key': `marks ${step.number}`,
    keydown: event => {
      if (!turn[event.key] || looks.length === 0) return;
      event.preventDefault();
      tell((told + turn[event.key] + looks.length) % looks.length);
    },
  }, [...marks].reverse()); // the best on top
}

// Where the view of this step was taken from, or where the robot stood.
function drawRobot(mission, step, unit) {
  const pose = step.view?.X_WC;
  if (!pose) {
    const start = step.way[0];
    return start ? el('circle', {class: 'robot', cx: cm(start.X_WB[0]), cy: cm(-start.X_WB[1]), r: 6 * unit, 'stroke-width': 1.5 * unit}) : null;
  }
  const [x, y] = pose.p;
  const {width, fx} = step.view.camera;
  const half = Math.atan2(width / 2, fx), angle = heading(pose), reach = 0.9;
  const ray = a => at(x + reach * Math.cos(angle + a), y + reach * Math.sin(angle + a));
  return el('g', {},
    el('path', {class: 'sight', d: `M${at(x, y)}L${ray(half)}L${ray(-half)}z`, 'stroke-width': unit, 'pointer-events': 'none'}),
    el('circle', {class: 'robot', cx: cm(x), cy: cm(-y), r: 6 * unit, 'stroke-width': 1.5 * unit}),
    el('title', {}, `The camera, at ${point(pose.p)} m`));
}

function drawLegend() {
  const sample = (label, ...shapes) => el('li', {}, el('svg', {viewBox: '0 0 16 12', 'aria-hidden': 'true'}, shapes), label);
  return el('ul', {class: 'legend'},
    sample('camera', el('circle', {class: 'robot', cx: 8, cy: 6, r: 5})),
    sample('possible look, fuller for a better score', el('path', {class: 'mark', d: 'M14 6L3 2L3 10z', 'fill-opacity': 0.6})),
    sample('refused', el('path', {class: 'mark refused', d: 'M14 6L3 2L3 10z'})),
    sample('taken', el('path', {class: 'mark chosen', d: 'M14 6L3 2L3 10z', 'stroke-width': 1.8})),
    sample('way to it', el('path', {class: 'way now', d: 'M1 6H15', 'stroke-width': 3})),
    sample('way before', el('path', {class: 'way', d: 'M1 6H15', 'stroke-width': 3})),
    sample('stopped short', el('path', {class: 'failed', d: 'M4 2L12 10M12 2L4 10', 'stroke-width': 2.5})),
    sample('occupied', el('rect', {class: 'occupied', x: 3, y: 1, width: 10, height: 10})));
}

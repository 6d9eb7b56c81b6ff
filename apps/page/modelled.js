// What was modelled, as nobody knew it: how much of its surface was seen after each scan.

function drawModelled(mission) {
  const things = mission.told?.modelled ?? [];
  if (things.length === 0) return [];
  return [
    el('h2', {}, 'What it modelled'),
    el('p', {class: 'note'}, 'The share of the surface that was seen after each scan, of what the support leaves free, as the model itself estimates it.'),
    el('div', {class: 'beliefs'}, things.map(thing => el('article', {class: 'belief'},
      el('h3', {}, `Object ${thing.object_id}: `,
        el('span', {class: `state ${thing.model ? 'verified' : 'unknown'}`}, thing.model || 'no model')),
      drawCoverage(thing),
      el('p', {class: 'note'}, `${plural(thing.coverage.length, 'scan')}, ${percent(thing.coverage.at(-1))} seen; ${thing.reason}`)))),
  ];
}

function drawCoverage(thing) {
  const width = 300, height = 132, left = 36, right = 8, top = 8, bottom = 18;
  const scans = thing.coverage.length;
  const x = scan => left + (width - left - right) * (scans > 1 ? (scan - 1) / (scans - 1) : 0.5);
  const y = share => top + (height - top - bottom) * (1 - share);
  const every = Math.ceil(scans / 10);
  const points = thing.coverage.map((share, i) => [x(i + 1), y(share)].map(v => v.toFixed(1)));
  return el('svg', {viewBox: `0 0 ${width} ${height}`, role: 'img', 'aria-label': `Seen of object ${thing.object_id} after each scan: ${thing.coverage.map(percent).join(', ')}`},
    [0, 0.5, 1].map(share => [
      el('line', {class: 'axis', x1: left, x2: width - right, y1: y(share), y2: y(share)}),
      el('text', {x: left - 5, y: y(share) + 3.5, 'text-anchor': 'end'}, percent(share))]),
    points.map(([at], i) => i % every ? null : el('text', {x: at, y: height - 4, 'text-anchor': 'middle'}, `${i + 1}`)),
    el('g', {style: 'stroke: var(--look); fill: var(--look)'},
      el('polyline', {class: 'course', points: points.map(p => p.join()).join(' ')}),
      points.map(([cx, cy]) => el('circle', {cx, cy, r: 3}))));
}

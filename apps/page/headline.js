// What was asked, what was found, how it ended.

function asked(task) {
  if (!task) return '';
  const rest = `anything at ${fixed(task.confidence)}`;
  if (task.wanted.length === 0) return `everything on the table, each at a confidence of ${fixed(task.confidence)}`;
  return `${listed(task.wanted.map(w => `${w.name} at ${fixed(w.confidence)}`))} (${rest} besides)`;
}

function found(objects) {
  const of = kind => objects.filter(o => standing(o) === kind);
  const parts = [];
  if (of('verified').length) parts.push(`found ${listed(of('verified').map(o => o.class_name))}`);
  if (of('unknown').length) parts.push(`met ${things(of('unknown').length)} it does not know`);
  if (of('open').length) parts.push(`left ${things(of('open').length)} open`);
  return parts.length ? `It ${parts.join('; ')}.` : 'It found nothing on a table.';
}

function foundSoFar(objects) {
  if (objects.length === 0) return 'It is looking for a table.';
  const of = kind => objects.filter(o => standing(o) === kind);
  const names = of('verified').map(o => o.class_name);
  const open = of('open').length;
  return `${names.length ? `So far it has found ${listed(names)}` : 'So far it has found nothing for sure'}` +
    `${of('unknown').length ? `; met ${things(of('unknown').length)} it does not know` : ''}` +
    `; ${open ? `${things(open)} still open` : 'nothing is open'}.`;
}

function things(count) {
  return count === 1 ? 'one thing' : `${count} things`;
}

function drawHeadline(mission) {
  if (!mission.told && mission.steps.length === 0) {
    return [el('h1', {}, 'No mission yet.'), el('p', {class: 'lead'}, 'Nothing has been told of a mission so far.')];
  }
  const objects = mission.objects();
  const costs = mission.costs();
  const told = mission.told;
  const spent = `${plural(costs.looks, 'look')}, ${fixed(costs.metres, 1)}\u00a0m and ${fixed(costs.seconds, 0)}\u00a0s of robot time`;
  const thinking = told && mission.ended ? `: ${fixed(told.motion_seconds, 0)}\u00a0s moving, ${fixed(told.compute_seconds, 0)}\u00a0s thinking` : '';
  return [
    el('h1', {}, mission.ended ? found(objects) : foundSoFar(objects)),
    el('p', {class: 'lead'},
      told ? `It was asked for ${asked(told.task)}. ` : 'Its beginning was not heard. ',
      mission.task ? `Meanwhile it was asked for ${asked(mission.task)}. ` : '',
      mission.ended ? `How it ended: ${told.end}. That took ${spent}${thinking}.` : `It has taken ${spent} so far.`),
  ];
}

function drawObjects(mission) {
  const objects = mission.objects();
  if (objects.length === 0) return [];
  return [
    el('h2', {}, 'What is on the table'),
    el('div', {class: 'wide'}, table('', [
      {head: 'Id', class: 'number', of: o => `${o.id}`},
      {head: 'State', class: 'state', mark: standing, of: o => standing(o)},
      {head: 'Class', class: 'name', of: o => standing(o) === 'unknown' ? 'none in the database' : nameOf(o)},
      {head: 'Confidence', class: 'number', of: o => fixed(confidence(o), 3)},
      {head: 'Position in W [m]', class: 'number', of: o => point(o.p_WO)},
      {head: 'Views', class: 'number', of: o => `${o.views}`},
      {head: 'Why', class: 'words', of: o => o.reason},
    ], objects)),
  ];
}

const HEALTH = ['unused', 'ok', 'silent', 'failed'];

function drawStatus(live) {
  const status = live.status;
  const lines = [];
  if (live.lost) lines.push(el('p', {class: 'fault'}, 'The monitor does not answer; what is shown here may be old.'));
  if (!status) {
    lines.push(el('p', {class: 'note'}, 'No STATUS has come: nothing is known of the process and its devices.'));
  } else {
    const silent = live.age > 3 ? ` (silent for ${fixed(live.age, 0)} s)` : '';
    lines.push(
      el('p', {}, el('strong', {}, status.phase), `, step ${status.step}: ${status.detail}${silent}`),
      el('div', {class: 'wide'}, table('', [
        {head: 'Device', class: 'name', of: d => `${d.kind} '${d.name}'`},
        {head: 'Health', class: 'state', mark: d => d.health === 3 ? 'fault' : '', of: d => HEALTH[d.health] ?? '?'},
        {head: 'Rate [Hz]', class: 'number', of: d => fixed(d.rate, 1)},
        {head: 'Dropped', class: 'number', of: d => `${d.drops}`},
        {head: 'Last error', class: 'words', of: d => d.last_error},
      ], status.devices)),
      el('p', {class: 'note'}, `It sent ${status.sent} messages (${status.send_drops} lost) and received ${status.received}`,
        ` (${status.rejected} refused, ${status.receive_drops} lost). `,
        status.last_rejected ? `Refused last: ${status.last_rejected}. ` : '',
        status.recording ? `Recording: ${status.recording}.` : 'It is not recorded.'));
  }
  if (live.rejected) lines.push(el('p', {class: 'fault'}, `${plural(live.rejected, 'message')} could not be read here: ${live.last_rejected}`));
  if (live.left_out) lines.push(el('p', {class: 'note'}, `${plural(live.left_out, 'older message')} no longer fit.`));
  return lines;
}

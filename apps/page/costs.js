// Where the time went, what was given up, and what it was set to.

function drawTime(mission) {
  const steps = mission.steps.filter(step => step.stages.length > 0);
  if (steps.length === 0) return [];
  const names = [...new Set(steps.flatMap(step => step.stages.map(stage => stage.name)))];
  const sum = (stages, key) => stages.reduce((total, stage) => total + (stage[key] ?? 0), 0);
  const longest = Math.max(1e-9, ...steps.map(step => sum(step.stages, 'robot_seconds')));
  const color = name => `var(--stage-${names.indexOf(name) % 4})`;
  const all = steps.flatMap(step => step.stages);
  return [
    el('h2', {}, 'Where the time went'),
    el('p', {class: 'note'}, 'Robot time of each step. Thinking is charged at fixed costs in simulation; wall time is what the machine took.'),
    el('div', {class: 'keys'}, names.map(name => el('span', {}, el('span', {class: 'key', style: `background: ${color(name)}; height: 10px`}), name))),
    el('div', {class: 'bars'}, steps.flatMap(step => [
      el('span', {}, `Step ${step.number}`),
      el('div', {class: 'bar'}, step.stages.map(stage => el('span', {
        style: `width: ${fixed(100 * stage.robot_seconds / longest, 2)}%; background: ${color(stage.name)}`,
        title: `${stage.name}: ${fixed(stage.robot_seconds, 1)} s`,
      }))),
      el('span', {}, `${fixed(sum(step.stages, 'robot_seconds'), 1)} s`)])),
    el('div', {class: 'wide totals'}, table('', [
      {head: 'Stage', class: 'name', of: row => row.name},
      {head: 'Robot time [s]', class: 'number', of: row => fixed(row.robot, 1)},
      {head: 'Wall time [s]', class: 'number', of: row => fixed(row.wall, 2)},
    ], [...names.map(name => [name, all.filter(stage => stage.name === name)]), ['all', all]]
      .map(([name, stages]) => ({name, robot: sum(stages, 'robot_seconds'), wall: sum(stages, 'wall_seconds')})))),
  ];
}

function drawGivenUp(mission) {
  if (!mission.told && mission.steps.length === 0) return [];
  const items = [];
  for (const object of mission.objects().filter(o => standing(o) === 'open')) {
    items.push(`Object ${object.id} (${nameOf(object)}) is open after ${plural(object.looks_taken, 'look')} for its sake: ${object.reason}.`);
  }
  for (const step of mission.steps) {
    if (step.view && step.view.index < 0) items.push(`Step ${step.number}: nothing was learned from the view: ${step.view.reason}.`);
    for (const status of step.way.filter(s => s.phase === NAV.FAILED || s.phase === NAV.STOPPED)) {
      items.push(`Step ${step.number}: the robot did not get where it was sent: ${status.reason}.`);
    }
  }
  const looks = mission.steps.flatMap(step => step.choice?.looks ?? []);
  const refused = looks.filter(look => !look.feasible);
  if (refused.length) items.push(`Of ${looks.length} candidate looks ${refused.length} were refused: ${counted(refused.map(refusal)).join(', ')}.`);
  return [
    el('h2', {}, 'What was given up, and why'),
    items.length ? el('ul', {class: 'plain'}, items.map(item => el('li', {}, item))) : el('p', {}, 'Nothing.'),
  ];
}

function drawConfiguration(mission) {
  if (!mission.told) return [];
  return [folded('configuration', 'The configuration', {},
    el('p', {class: 'note'}, `Models in the database: ${listed(mission.told.models)}.`),
    el('pre', {tabindex: 0, 'data-key': 'yaml'}, mission.told.config))];
}

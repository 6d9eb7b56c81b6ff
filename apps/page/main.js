// One page from two sources: the messages that it holds, or those that a monitor goes on to bring.

const POLL_MS = 500;

const ui = {step: null, follows: true}; // the step that is shown; the newest, until one is chosen
let mission = new Mission();
const live = {on: false, server: '', story: 0, next: 0, status: null, heard: 0, age: 0, lost: false, rejected: 0, last_rejected: '', left_out: 0};

// Redraws a section when what it shows has changed; what has the focus keeps it.
const drawn = new Map();
function redraw(id, version, draw) {
  const section = document.getElementById(id);
  if (drawn.get(id) === version) return;
  drawn.set(id, version);
  const key = section.contains(document.activeElement) ? document.activeElement.dataset.key : null;
  const scrolled = [...section.querySelectorAll('.strip')].map(e => e.scrollLeft);
  section.replaceChildren(...draw().filter(child => child !== null));
  section.querySelectorAll('.strip').forEach((e, i) => { e.scrollLeft = scrolled[i] ?? 0; });
  if (key) section.querySelector(`[data-key="${CSS.escape(key)}"]`)?.focus({preventScroll: true});
}

function render() {
  const steps = mission.steps;
  const shown = steps.filter(step => step.messages > 1 || step.view);
  if (ui.follows || !mission.byNumber.has(ui.step)) ui.step = (shown.filter(s => s.view).at(-1) ?? steps.at(-1))?.number ?? null;
  const told = mission.told;
  const count = steps.reduce((sum, step) => sum + step.messages, 0);
  const version = `${live.story} ${count} ${mission.images.size} ${told?.end}`;
  const selected = mission.byNumber.get(ui.step);
  document.title = told ? `Second Look, seed ${told.seed}` : 'Second Look';
  document.getElementById('origin').textContent =
    [live.on ? 'live' : 'mission report', told && `seed ${told.seed}`, told && `version ${told.version}`].filter(Boolean).join(' · ');
  redraw('headline', `${version} ${JSON.stringify(mission.task)}`, () => drawHeadline(mission));
  if (live.on) {
    document.getElementById('status').hidden = false;
    redraw('status', JSON.stringify(live), () => drawStatus(live));
  }
  const beliefs = steps.filter(step => step.belief).reduce((sum, step) => sum + step.belief.objects.length, 0);
  redraw('objects', `${live.story} ${beliefs}`, () => drawObjects(mission));
  redraw('steps', `${version} ${ui.step}`, () => selected ? [
    el('h2', {}, 'Step by step'),
    drawStrip(mission, ui.step, choose),
    drawStep(mission, selected, ui),
  ] : []);
  redraw('belief', `${live.story} ${beliefs} ${ui.step}`, () => drawBeliefs(mission, ui));
  redraw('modelled', version, () => drawModelled(mission));
  redraw('time', `${live.story} ${steps.reduce((sum, step) => sum + step.stages.length, 0)}`, () => drawTime(mission));
  redraw('given-up', version, () => drawGivenUp(mission));
  redraw('configuration', `${live.story} ${told?.utime}`, () => drawConfiguration(mission));
}

function choose(number) {
  ui.step = number;
  ui.follows = live.on && number === mission.steps.at(-1).number;
  render();
}

async function poll() {
  try {
    const answer = await fetch(`messages?story=${live.story}&from=${live.next}`);
    if (!answer.ok) throw new Error(`status ${answer.status}`);
    const news = await answer.json();
    const {server, story, next, left_out, rejected, last_rejected, status, status_age, messages} = news;
    const restarted = live.server !== '' && server !== live.server;
    if (story !== live.story || restarted) {
      mission = new Mission();
      ui.follows = true;
    }
    if (!restarted) messages.forEach(message => mission.add(message));
    Object.assign(live, {server, story, next, left_out, rejected, last_rejected, status, age: Math.floor(status_age ?? 0), lost: false});
    if (restarted) Object.assign(live, {story: 0, next: 0}); // it counts anew: ask for all
  } catch {
    live.lost = true;
  }
  render();
  setTimeout(poll, POLL_MS);
}

addEventListener('keydown', event => {
  const turn = {'[': -1, ']': 1}[event.key];
  const steps = mission.steps;
  const next = steps[steps.findIndex(step => step.number === ui.step) + turn];
  if (turn && next && !event.ctrlKey && !event.metaKey && !event.altKey) choose(next.number);
});

const story = JSON.parse(document.getElementById('story').textContent);
if (story.live) {
  live.on = true;
  poll();
} else {
  story.messages.forEach(message => mission.add(message));
  ui.follows = false;
  ui.step = mission.steps.find(step => step.look && step.choice)?.number ?? mission.steps.at(-1)?.number ?? null;
  render();
}

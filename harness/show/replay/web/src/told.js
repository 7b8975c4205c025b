// What is told beside the view: the task with its neighbours, the runs, how the one that is followed ended, and scales.
import { gradient } from './data.js';

const $ = (id) => document.getElementById(id);
const make = (tag, text = '') => Object.assign(document.createElement(tag), { textContent: text });

// Texts come from planners: they are set as text, never as markup.
export function tellTask(data, follow) {
  document.title = `${data.task} on ${data.suite}`;
  $('task').textContent = data.task;
  $('labels').textContent = `${data.labels[0]} elevation, ${data.labels[1]} terrain, ${data.labels[2]} obstacles · ${data.suite}`;
  for (const [kind, sign] of [['report', '↑ '], ['previous', '← '], ['next', '']]) {
    const link = data.links?.[kind];
    if (!link) continue;
    const a = make('a', `${sign}${link.name}${kind === 'next' ? ' →' : ''}`);
    a.id = kind;
    a.href = link.href;
    a.title = { report: 'the page that lists this replay', previous: 'the previous replay', next: 'the next replay' }[kind];
    $('links').append(a);
  }
  $('links').hidden = !$('links').children.length;
  data.runs.forEach((run, k) => {
    const li = make('li');
    const button = make('button');
    button.type = 'button';
    const swatch = make('i');
    swatch.style.background = run.colour;
    const outcome = make('em', `${run.outcome}, ${run.time.toFixed(1)} s`);
    outcome.className = run.success ? 'good' : 'bad';
    button.append(swatch, make('span', run.label), outcome);
    button.title = run.exact ? 're-simulated, bit-identical to the record' : 'from recorded samples, without ruts, loads and slip';
    button.addEventListener('click', () => follow(k));
    li.append(button);
    $('runs').append(li);
  });
  for (const c of data.semantics.classes.filter((x) => x.there)) {
    const li = make('li');
    const swatch = make('i');
    swatch.style.background = `rgb(${c.colour})`;
    li.append(swatch, c.soil ? `${c.name}, ${c.soil}` : c.name);
    $('classes').append(li);
  }
  const thin = data.runs.map((run) => run.sensed).find((s) => s.scans_of || s.maps_of || s.images_of);
  if (thin) {
    const of = ['scans', 'images', 'maps'].filter((name) => thin[`${name}_of`]);
    $('sensed').textContent = `sensors: ${of.map((name) => `${thin[name].length} of ${thin[`${name}_of`]} ${name}`).join(', ')} are shown`;
  }
  for (const run of data.runs) {
    const mark = make('i');
    mark.style.left = `${(100 * run.end) / data.end}%`;
    mark.className = run.success ? 'good' : 'bad';
    mark.title = `${run.label}: ${run.outcome}`;
    $('marks').append(mark);
  }
}

// With what a run was driven, and why it ended.
export function tellRun(run) {
  $('facts').replaceChildren(...run.facts.flatMap(([term, text]) => [make('dt', term), make('dd', text)]));
  if (!run.exact) $('facts').append(make('dt', 'shown'), make('dd', 'recorded samples, without ruts, loads and slip'));
}

// How the run that is followed ended, once it has.
export function tellEnd(run, time) {
  const over = time >= run.end - 1e-3;
  const box = $('banner');
  box.hidden = !over;
  box.className = run.success ? 'good' : 'bad';
  box.textContent = over ? `${run.outcome} after ${run.time.toFixed(2)} s${run.success ? '' : `: ${run.reason}`}` : '';
}

// What the colours of the trail mean.
export function tellTrail(by, end) {
  $('scale').hidden = by === 'run';
  $('scale-bar').style.background = gradient();
  $('scale-end').textContent = by === 'speed' ? `${end.toFixed(1)} m/s` : `${end.toFixed(0)}°`;
}

// A length on a map that is as long as possible, but at most so many metres: 1, 2 or 5 times a power of ten.
export function roundLength(most) {
  const power = 10 ** Math.floor(Math.log10(most));
  return [5, 2, 1].map((m) => m * power).find((v) => v <= most * (1 + 1e-9)) ?? power;
}

const BAR = 120; // px at most

// The scale of the view from above; none of other views.
export function tellMap(metresPerPixel) {
  $('map').hidden = metresPerPixel === null;
  if (metresPerPixel === null) return;
  const length = roundLength(BAR * metresPerPixel);
  $('map-bar').style.width = `${(length / metresPerPixel).toFixed(1)}px`;
  $('map-length').textContent = length < 1 ? `${Math.round(100 * length)} cm` : `${length} m`;
}

// Curves over time beside the view, with scales; a click or drag goes to a time.
import { SIGNALS } from './data.js';

const signalOf = (run, which) => ({ times: run.times, value: (k) => run.signals[SIGNALS * k + which] });
const curveOf = (points) => ({ times: points.map((p) => p[0]), value: (k) => points[k][1] });

const LEFT = 34; // room for the values, px
const BELOW = 14; // room for the times, px
const ABOVE = 5;

// Round numbers within a range, `most` at most; of 1, 2 and 5 times a power of ten.
export function ticks(low, high, most) {
  const raw = (high - low) / Math.max(1, most);
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= raw * (1 - 1e-9));
  const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const values = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k += 1) values.push(k * step);
  return values.map((v) => ({ at: v, text: v.toFixed(digits).replace('-', '−') }));
}

export class Plots {
  constructor(data, host, seek) {
    Object.assign(this, { data, host, seek, followed: 0, plots: [] });
    this.make();
  }

  // Figures of all runs, and the commands and the planner's curves of the one that is followed.
  make() {
    const { data } = this;
    const runs = data.runs;
    const all = (which) => runs.map((run, k) => ({ ...signalOf(run, which), colour: run.colour, faint: k !== this.followed }));
    const own = runs[this.followed];
    const list = [
      ['speed', 'm/s', all(0)],
      ['roll', '°', all(1)],
      ['pitch', '°', all(2)],
      ['steering, throttle, brake', '', [
        { ...signalOf(own, 3), colour: '--steering', name: 'steering' },
        { ...signalOf(own, 4), colour: '--throttle', name: 'throttle' },
        { ...signalOf(own, 5), colour: '--brake', name: 'brake' },
      ]],
      ...Object.entries(own.series.curves).map(([name, points]) => [name, '', [{ ...curveOf(points), colour: '--curve' }]]),
    ];
    this.host.replaceChildren();
    this.plots = list.map(([title, unit, lines]) => {
      const figure = document.createElement('figure');
      const caption = document.createElement('figcaption');
      const value = document.createElement('output');
      const canvas = document.createElement('canvas');
      caption.append(Object.assign(document.createElement('span'), { textContent: unit ? `${title}, ${unit}` : title }), value);
      const cursor = document.createElement('i');
      const area = document.createElement('div');
      area.append(canvas, cursor);
      figure.append(caption, area);
      this.host.append(figure);
      let low = 0;
      let high = 0;
      for (const line of lines) {
        for (let k = 0; k < line.times.length; k += 1) {
          low = Math.min(low, line.value(k));
          high = Math.max(high, line.value(k));
        }
      }
      if (high - low < 1e-9) high = low + 1;
      const go = (event) => {
        const box = canvas.getBoundingClientRect();
        this.seek(((event.clientX - box.left - LEFT) / (box.width - LEFT)) * this.data.end);
      };
      canvas.addEventListener('pointerdown', (event) => { canvas.setPointerCapture(event.pointerId); go(event); });
      canvas.addEventListener('pointermove', (event) => { if (event.buttons & 1) go(event); });
      return { lines, low, high, canvas, cursor, value };
    });
    this.draw();
  }

  // The curves with their scales; the cursor is an element over them.
  draw() {
    const style = getComputedStyle(document.documentElement);
    const colour = (name) => (name.startsWith('--') ? style.getPropertyValue(name).trim() : name);
    const { end } = this.data;
    for (const plot of this.plots) {
      const { canvas, lines, low, high } = plot;
      const ratio = window.devicePixelRatio || 1;
      const [wide, tall] = [canvas.clientWidth, canvas.clientHeight];
      if (!wide || !tall) continue;
      canvas.width = Math.round(wide * ratio);
      canvas.height = Math.round(tall * ratio);
      const c = canvas.getContext('2d');
      c.scale(ratio, ratio);
      const x = (t) => LEFT + (t / end) * (wide - LEFT);
      const y = (v) => tall - BELOW - ((v - low) / (high - low)) * (tall - BELOW - ABOVE);
      c.font = '10px system-ui, sans-serif';
      c.fillStyle = colour('--soft');
      c.lineWidth = 1;
      const line = (points) => { c.beginPath(); points.forEach(([u, v]) => c.lineTo(u, v)); c.stroke(); };
      c.textBaseline = 'middle';
      c.textAlign = 'right';
      for (const { at, text } of ticks(low, high, 3)) {
        c.strokeStyle = colour(at === 0 ? '--axis' : '--grid');
        line([[LEFT, y(at)], [wide, y(at)]]);
        c.fillText(text, LEFT - 5, Math.min(tall - BELOW, Math.max(ABOVE + 1, y(at))));
      }
      c.textBaseline = 'bottom';
      plot.times = ticks(0, end, Math.max(2, Math.floor((wide - LEFT) / 44)));
      plot.times.forEach(({ at, text }, k) => {
        c.strokeStyle = colour('--grid');
        line([[x(at), ABOVE], [x(at), tall - BELOW + 2]]);
        const label = k === 0 ? `${text} s` : text;
        c.textAlign = k === 0 ? 'left' : x(at) + 0.5 * c.measureText(label).width > wide ? 'right' : 'center';
        c.fillText(label, c.textAlign === 'right' ? wide : x(at), tall);
      });
      for (const own of lines) {
        c.strokeStyle = colour(own.colour);
        c.globalAlpha = own.faint ? 0.45 : 1;
        c.lineWidth = 1.4;
        c.beginPath();
        const step = Math.max(1, Math.floor(own.times.length / (2 * wide * ratio)));
        for (let k = 0; k < own.times.length; k += step) c.lineTo(x(own.times[k]), y(own.value(k)));
        c.stroke();
      }
      c.globalAlpha = 1;
    }
  }

  cursor(t, locate) {
    for (const plot of this.plots) {
      const { lines, cursor } = plot;
      cursor.style.left = `calc(${LEFT}px + (100% - ${LEFT}px) * ${t / this.data.end})`;
      const told = lines.filter((l) => !l.faint && l.times.length);
      plot.value.replaceChildren(...told.map((l) => {
        const span = document.createElement('span');
        span.textContent = `${l.value(locate(l.times, t)[0]).toFixed(told.length > 1 ? 2 : 1).replace('-', '−')} `;
        span.title = l.name ?? '';
        if (told.length > 1) span.style.color = `var(${l.colour})`;
        return span;
      }));
    }
  }
}

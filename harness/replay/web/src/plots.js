// Curves over time beside the view; a click or drag goes to a time.
import { SIGNALS } from './data.js';

const signalOf = (run, which) => ({ times: run.times, value: (k) => run.signals[SIGNALS * k + which] });
const curveOf = (points) => ({ times: points.map((p) => p[0]), value: (k) => points[k][1] });

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
        { ...signalOf(own, 3), colour: '#8fb7ff', name: 'steering' },
        { ...signalOf(own, 4), colour: '#6bd09b', name: 'throttle' },
        { ...signalOf(own, 5), colour: '#f0856f', name: 'brake' },
      ]],
      ...Object.entries(own.series.curves).map(([name, points]) => [name, '', [{ ...curveOf(points), colour: '#e8c66a' }]]),
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
        this.seek(((event.clientX - box.left) / box.width) * this.data.end);
      };
      canvas.addEventListener('pointerdown', (event) => { canvas.setPointerCapture(event.pointerId); go(event); });
      canvas.addEventListener('pointermove', (event) => { if (event.buttons & 1) go(event); });
      return { lines, low, high, canvas, cursor, value };
    });
    this.draw();
  }

  // The curves; the cursor is an element over them.
  draw() {
    for (const plot of this.plots) {
      const { canvas, lines, low, high } = plot;
      const ratio = window.devicePixelRatio || 1;
      const [w, h] = [canvas.clientWidth * ratio, canvas.clientHeight * ratio].map(Math.round);
      if (!w || !h) continue;
      canvas.width = w;
      canvas.height = h;
      const c = canvas.getContext('2d');
      const y = (v) => h - 2 * ratio - ((v - low) / (high - low)) * (h - 4 * ratio);
      c.strokeStyle = 'rgba(255,255,255,.25)';
      c.beginPath();
      c.moveTo(0, y(0));
      c.lineTo(w, y(0));
      c.stroke();
      for (const line of lines) {
        c.strokeStyle = line.colour;
        c.globalAlpha = line.faint ? 0.45 : 1;
        c.lineWidth = 1.4 * ratio;
        c.beginPath();
        const step = Math.max(1, Math.floor(line.times.length / (2 * w)));
        for (let k = 0; k < line.times.length; k += step) {
          const x = (line.times[k] / this.data.end) * w;
          if (k === 0) c.moveTo(x, y(line.value(k)));
          else c.lineTo(x, y(line.value(k)));
        }
        c.stroke();
      }
      c.globalAlpha = 1;
    }
  }

  cursor(t, locate) {
    for (const plot of this.plots) {
      const { lines, cursor } = plot;
      cursor.style.left = `${(100 * t) / this.data.end}%`;
      const told = lines.filter((l) => !l.faint && l.times.length);
      plot.value.replaceChildren(...told.map((l) => {
        const span = document.createElement('span');
        span.textContent = `${l.value(locate(l.times, t)[0]).toFixed(told.length > 1 ? 2 : 1)} `;
        span.title = l.name ?? '';
        if (told.length > 1) span.style.color = l.colour;
        return span;
      }));
    }
  }
}

//! Runs beside each other, moment by moment.

use std::sync::Arc;

use crate::{RUN_COLOURS, Replay};
use vb_figure::Overlay;
use vb_render::{Painter, Size};
use vb_vehicle::VehicleModel;
use vb_world::TaskId;

use crate::film::layout::Layout;
use crate::film::panel::{Panel, Stage};
use crate::film::{Camera, FilmError, caption};

/// What is between panels, and where there is none.
const GROUND: [u8; 3] = [22, 24, 28];

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Style {
    pub camera: Camera,
    /// The size of a frame, pixels.
    pub size: Size,
    /// Whether the run, the time, the speed and the outcome are written over the pictures.
    pub captions: bool,
}

/// A task with its runs, as it is filmed: a panel for each run, in a frame.
pub struct Film {
    task: TaskId,
    style: Style,
    layout: Layout,
    stage: Stage,
    panels: Vec<Panel>,
    title: Option<Overlay>,
}

impl Film {
    /// Prepares a film: the colours of the ground, the way of the camera.
    ///
    /// # Errors
    /// Returns an error if a run has no frames, or a vehicle with other wheels than its trace; if there are more runs than can be
    /// shown beside each other; and if the frame is too small or too large.
    pub fn new(replay: &Replay, style: Style) -> Result<Self, FilmError> {
        let task = replay.id();
        let layout = Layout::new(replay.runs.len(), style.size)?;
        let mut painters: Vec<(&vb_vehicle::VehicleSpec, Arc<Painter>)> = Vec::new();
        let mut panels = Vec::new();
        for (k, run) in replay.runs.iter().enumerate() {
            let wrong = |reason| FilmError::Run { run: run.label.clone(), task: task.clone(), reason };
            if run.motion.frames.is_empty() {
                return Err(wrong("its trace has no samples (re-run the task with --trace 10hz or full)"));
            }
            let spec = &*run.vehicle;
            if run.motion.wheels != 2 * spec.axles.len() {
                return Err(wrong(
                    "its vehicle has other wheels than the trace (give the run's vehicle with --vehicle)",
                ));
            }
            let painter = match painters.iter().find(|(of, _)| *of == spec) {
                Some((_, painter)) => painter.clone(),
                None => {
                    let model = VehicleModel::new(spec.clone()).map_err(|_| {
                        wrong("its vehicle cannot be rendered (give the run's vehicle with --vehicle)")
                    })?;
                    let painter = Arc::new(Painter::new(&replay.world, &model));
                    painters.push((spec, painter.clone()));
                    painter
                }
            };
            panels.push(Panel::new(
                run,
                &replay.world,
                painter,
                spec.length,
                style.camera,
                RUN_COLOURS[k % RUN_COLOURS.len()],
            ));
        }
        let title = if style.captions {
            let mut text = format!("{} {task}", replay.suite);
            // The vehicle, where all runs have the same.
            if let [(spec, _)] = painters[..] {
                text += &format!(" · {}", spec.name);
            }
            Some(caption::of_film(&text, layout.panel)?)
        } else {
            None
        };
        let stage = Stage {
            goal: if replay.has_goal { replay.task.goal } else { [f64::NAN; 2] },
            goal_radius: replay.goal_radius.unwrap_or(0.0),
            path: replay.task.path.clone(),
        };
        Ok(Self { task, style, layout, stage, panels, title })
    }

    /// When the last of the runs ended, s.
    #[must_use]
    pub fn end(&self) -> f64 {
        self.panels.iter().map(Panel::end).fold(0.0, f64::max)
    }

    /// The size of a frame, pixels.
    #[must_use]
    pub fn size(&self) -> Size {
        self.style.size
    }

    /// The frame of a moment, s: red, green and blue in sRGB of each pixel, row by row from the top. A run that has ended
    /// stays as it was at its end.
    ///
    /// # Errors
    /// Returns an error if a pose of the vehicle is not finite, or if the frame is too large.
    pub fn frame(&self, time: f64) -> Result<Vec<u8>, FilmError> {
        let columns = self.style.size.width as usize;
        let mut frame = Vec::new();
        let size = self.layout.panel;
        let width = 3 * size.width as usize;
        for (k, panel) in self.panels.iter().enumerate() {
            let [x, y] = self.layout.corner(k);
            let picture = panel
                .picture(&self.stage, time, size)
                .map_err(|source| FilmError::Picture { task: self.task.clone(), source })?;
            if size == self.style.size {
                // The only panel.
                frame = picture;
            } else {
                if k == 0 {
                    frame = GROUND.repeat(columns * self.style.size.height as usize);
                }
                let rows = frame.chunks_exact_mut(3 * columns).skip(y);
                for (row, source) in rows.zip(picture.chunks_exact(width)) {
                    row[3 * x..3 * x + width].copy_from_slice(source);
                }
            }
            if self.style.captions {
                caption::of_run(&panel.said(time), size)?.lay_over(&mut frame, columns, [x, y]);
            }
        }
        if let Some(title) = &self.title {
            title.lay_over(&mut frame, columns, [0, 0]);
        }
        Ok(frame)
    }
}

//! Policies whose networks were trained in an environment.

use super::{ActionKind, Actuator, Dtype, Layout, Observer, Part, Row, Sight};
use crate::nn::{LANES, Lanes, Network, Scratch, Weights};
use crate::{Command, Observation, PlannerError, Task};

/// The control rate for which policies are trained, Hz.
const CONTROL_HZ: &str = "10";
/// The slope of the activation after the convolution, which is that of [`Network`].
const LEAK: f32 = crate::nn::LEAK;

/// What a file of weights says of the policy that it is for, in its notes.
///
/// - `parts`: the names of the parts of an observation, with blanks between them;
/// - `sight`: cells, resolution, ahead, points and spacing of [`Sight`];
/// - `labels`: the labels of which planes are made, one for each label and each part of labels: 1 where the label is, else 0;
/// - `action`: `speed SLOWEST FASTEST`, `rate SLOWEST FASTEST` or `pedals` ([`ActionKind`]);
/// - `control_hz`: 10.
///
/// `python -m vertibench.training export` writes such files.
#[derive(Clone, Debug, PartialEq)]
pub struct PolicySpec {
    /// The names of the parts of an observation.
    pub parts: Vec<String>,
    /// What is seen of the surroundings.
    pub sight: Sight,
    /// The labels of which planes are made.
    pub labels: Vec<u8>,
    /// What an action means.
    pub action: ActionKind,
}

impl PolicySpec {
    /// Reads what a file of weights says of its policy.
    ///
    /// # Errors
    /// Returns an error that names the note that is missing or wrong.
    pub fn of(weights: &Weights) -> Result<Self, PlannerError> {
        let note = |key: &str| {
            weights
                .note(key)
                .ok_or_else(|| PlannerError::from(format!("weights: {key}: the note is missing")))
        };
        let wrong = |key: &str, value: &str, want: &str| {
            PlannerError::from(format!("weights: {key}: \"{value}\" is not {want}"))
        };
        let sight = note("sight")?;
        let sizes: Option<Vec<f64>> = sight.split(' ').map(|n| n.parse().ok()).collect();
        let Some([cells, resolution, ahead, points, spacing]) = sizes.as_deref() else {
            return Err(wrong("sight", sight, "cells, resolution, ahead, points and spacing"));
        };
        let labels = note("labels")?;
        let wanted = labels.split_whitespace().map(|n| n.parse().ok()).collect();
        let Some(wanted): Option<Vec<u8>> = wanted else {
            return Err(wrong("labels", labels, "a list of labels from 0 to 255"));
        };
        let action = note("action")?;
        let kind = match action.split(' ').collect::<Vec<_>>()[..] {
            ["pedals"] => Some(ActionKind::Pedals),
            [name @ ("speed" | "rate"), slowest, fastest] => match (slowest.parse(), fastest.parse()) {
                (Ok(slowest), Ok(fastest)) if slowest < fastest => Some(match name {
                    "rate" => ActionKind::Rate { slowest, fastest },
                    _ => ActionKind::Speed { slowest, fastest },
                }),
                _ => None,
            },
            _ => None,
        };
        let kind = kind.ok_or_else(|| {
            wrong("action", action, "\"speed SLOWEST FASTEST\", \"rate SLOWEST FASTEST\" or \"pedals\"")
        })?;
        let rate = note("control_hz")?;
        if rate != CONTROL_HZ {
            return Err(wrong("control_hz", rate, "10, at which planners of policies are asked"));
        }
        Ok(Self {
            parts: note("parts")?.split_whitespace().map(str::to_owned).collect(),
            sight: Sight {
                cells: *cells as usize,
                resolution: *resolution,
                ahead: *ahead,
                points: *points as usize,
                spacing: *spacing,
            },
            labels: wanted,
            action: kind,
        })
    }
}

/// A policy's networks: numbers of an observation in, an action out.
///
/// Crops are planes for a convolution, the network `eyes` of one layer; all other numbers go beside what it gives into the network
/// `head`. Numbers are divided by their usual sizes and limited, as in a flat observation. A part of labels makes a plane for each
/// label of [`PolicySpec::labels`]. Planes of numbers come first, in the order of the parts, then those of labels.
#[derive(Clone, Debug)]
pub struct PolicyNetwork {
    parts: Vec<Part>,
    labels: Vec<u8>,
    eyes: Option<Network>,
    head: Network,
    planes: Vec<Lanes>,
    inputs: Vec<Lanes>,
    outputs: Vec<Lanes>,
    scratch: Scratch,
}

/// The numbers of a part of an observation.
#[derive(Clone, Copy, Debug)]
pub enum Numbers<'a> {
    /// Of a part of [`Dtype::F32`].
    F32(&'a [f32]),
    /// Of a part of [`Dtype::U8`].
    U8(&'a [u8]),
}

impl PolicyNetwork {
    /// The networks of a file of weights, for observations of this layout.
    ///
    /// # Errors
    /// Returns an error if the file has no such networks, or they don't fit the layout.
    pub fn new(weights: &Weights, spec: &PolicySpec, layout: &Layout) -> Result<Self, PlannerError> {
        let parts = layout.parts().to_vec();
        let cells = layout.sight().cells.pow(2);
        let planes_of = |p: &Part| if p.dtype == Dtype::F32 { 1 } else { spec.labels.len() };
        let planes: usize = parts.iter().filter(|p| p.is_crop()).map(planes_of).sum();
        let others: usize = parts.iter().filter(|p| !p.is_crop()).map(Part::width).sum();
        if let Some(part) = parts.iter().find(|p| p.dtype == Dtype::U8 && !p.is_crop()) {
            return Err(
                format!("weights: parts: {}: labels that are no crop can't be seen", part.name).into()
            );
        }
        let eyes = match planes {
            0 => None,
            _ => {
                let outputs =
                    weights.layers.iter().find(|l| l.name == "eyes.0").map_or(0, |l| l.shape.outputs());
                Some(weights.network("eyes", planes * cells, outputs)?)
            }
        };
        let seen = eyes.as_ref().map_or(0, Network::outputs);
        let head = weights.network("head", seen + others, spec.action.dimensions().len())?;
        Ok(Self {
            labels: spec.labels.clone(),
            planes: vec![[0.0; LANES]; planes * cells],
            inputs: vec![[0.0; LANES]; seen + others],
            outputs: vec![[0.0; LANES]; head.outputs()],
            parts,
            eyes,
            head,
            scratch: Scratch::default(),
        })
    }

    /// The action for an observation, whose parts come in the order of the layout. Missing numbers count as 0.
    pub fn act(&mut self, parts: &[Numbers<'_>]) -> Vec<f64> {
        let seen = self.eyes.as_ref().map_or(0, Network::outputs);
        let mut planes = self.planes.iter_mut();
        let mut inputs = self.inputs[seen..].iter_mut();
        for (part, numbers) in self.parts.iter().zip(parts) {
            let Numbers::F32(numbers) = numbers else { continue };
            for (k, value) in numbers.iter().take(part.width()).enumerate() {
                let scaled = value / part.entry(k).usual as f32;
                let to = if part.is_crop() { planes.next() } else { inputs.next() };
                if let Some(to) = to {
                    to[0] = scaled.clamp(-Layout::FLAT_BOUND, Layout::FLAT_BOUND);
                }
            }
        }
        for numbers in parts {
            let Numbers::U8(numbers) = numbers else { continue };
            for label in &self.labels {
                for (value, to) in numbers.iter().zip(&mut planes) {
                    to[0] = f32::from(u8::from(value == label));
                }
            }
        }
        if let Some(eyes) = &self.eyes {
            eyes.run(&self.planes, &mut self.inputs[..seen], &mut self.scratch);
            for value in &mut self.inputs[..seen] {
                let leak = LEAK * value[0];
                value[0] = if value[0] < leak { leak } else { value[0] };
            }
        }
        self.head.run(&self.inputs, &mut self.outputs, &mut self.scratch);
        self.outputs.iter().map(|o| f64::from(o[0])).collect()
    }
}

/// A policy that was trained, as it drives: what it sees, its networks, and what it does.
#[derive(Clone, Debug)]
pub struct Trained {
    layout: Layout,
    observer: Observer,
    actuator: Actuator,
    network: PolicyNetwork,
    /// Room for the numbers of each part.
    numbers: Vec<Vec<f32>>,
    labels: Vec<Vec<u8>>,
}

impl Trained {
    /// The policy of a file of weights, for a task.
    ///
    /// # Errors
    /// Returns an error if the file isn't one of a policy, or sees what the task's perception doesn't give.
    pub fn new(weights: &Weights, task: &Task) -> Result<Self, PlannerError> {
        let spec = PolicySpec::of(weights)?;
        let layout = Layout::new(&spec.parts, spec.sight, task)?;
        let room = |dtype: Dtype| move |p: &Part| if p.dtype == dtype { p.width() } else { 0 };
        Ok(Self {
            observer: Observer::new(task, &layout)?,
            actuator: Actuator::new(spec.action, task),
            network: PolicyNetwork::new(weights, &spec, &layout)?,
            numbers: layout.parts().iter().map(room(Dtype::F32)).map(|n| vec![0.0; n]).collect(),
            labels: layout.parts().iter().map(room(Dtype::U8)).map(|n| vec![0; n]).collect(),
            layout,
        })
    }

    /// The command for an observation of the task.
    ///
    /// # Errors
    /// Returns an error if the action isn't finite, as after an observation that makes no sense.
    pub fn step(&mut self, task: &Task, observation: &Observation) -> Result<Command, PlannerError> {
        self.observer.look(observation);
        let mut parts = Vec::with_capacity(self.numbers.len());
        let rows = self.numbers.iter_mut().zip(&mut self.labels);
        for (part, (numbers, labels)) in self.layout.parts().iter().zip(rows) {
            parts.push(match part.dtype {
                Dtype::F32 => {
                    self.observer.fill(task, part, Row::F32(numbers));
                    Numbers::F32(numbers)
                }
                Dtype::U8 => {
                    self.observer.fill(task, part, Row::U8(labels));
                    Numbers::U8(labels)
                }
            });
        }
        let action = self.network.act(&parts);
        if action.iter().any(|a| !a.is_finite()) {
            return Err("the policy's action is not finite: the observation makes no sense".into());
        }
        Ok(self.actuator.command(&action, observation))
    }
}

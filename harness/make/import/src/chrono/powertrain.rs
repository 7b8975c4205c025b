//! Engines and transmissions.

use super::json::{Doc, Node};
use super::set::template;
use crate::{ImportError, Notes};
use std::f64::consts::PI;
use vb_vehicle::powertrain::{Converter, DirectionChange, Engine, Gearbox};
use vb_vehicle::table::interpolate;

/// Speed of a converter's engine at rest, rad/s: 650 rpm, as of the shipped vehicles.
const IDLE: f64 = 68.0;
/// Gears that stand for a continuously variable transmission.
const STEPS: usize = 6;

fn rad(rpm: f64) -> f64 {
    rpm * PI / 30.0
}

/// Points over rpm as points over rad/s, from standstill on.
fn curve(node: &Node) -> Result<Vec<[f64; 2]>, ImportError> {
    let mut points: Vec<[f64; 2]> = node.table()?.iter().map(|p| [rad(p[0]), p[1]]).collect();
    points.sort_by(|a, b| a[0].total_cmp(&b[0]));
    points.dedup_by(|a, b| a[0] == b[0]);
    if points[0][0] < 0.0 {
        let at_rest = interpolate(&points, 0.0).0;
        points.retain(|p| p[0] > 0.0);
        points.insert(0, [0.0, at_rest]);
    }
    Ok(points)
}

/// Reads an engine, or that of a powertrain of Chrono 8 and before.
pub(crate) fn engine(doc: &Doc, notes: &mut Notes) -> Result<Engine, ImportError> {
    let root = doc.root();
    match template(doc)?.as_str() {
        "EngineSimple" | "SimpleCVTPowertrain" => {
            let (torque, power) = (root.num("Maximum Engine Torque")?, root.num("Maximum Engine Power")?);
            let max_speed = match root.get("Maximum Engine Speed") {
                Some(n) => n.number()?,
                None => {
                    let speed = 10.0 * power / torque;
                    notes.assumed(format!(
                        "{}: a maximum engine speed of {speed:.0} rad/s, ten times that of the full torque at full power",
                        doc.file
                    ));
                    speed
                }
            };
            Ok(Engine::Simple { torque, power, max_speed, inertia: 0.0 })
        }
        "SimplePowertrain" => {
            let (torque, speed) = (root.num("Maximum Engine Torque")?, root.num("Maximum Engine Speed")?);
            Ok(Engine::Map {
                full_throttle: vec![[0.0, torque], [speed, 0.0]],
                closed_throttle: vec![[0.0, 0.0], [speed, 0.0]],
                inertia: 0.0,
            })
        }
        "EngineSimpleMap" => map(&root, doc, notes),
        "SimpleMapPowertrain" => map(&root.need("Engine")?, doc, notes),
        "EngineShafts" => {
            let inertia = root.num("Motorshaft Inertia")?;
            lossy(&root, inertia, doc, notes)
        }
        "ShaftsPowertrain" => {
            let node = root.need("Engine")?;
            let inertia = node.num("Crankshaft Inertia")?;
            lossy(&node, inertia, doc, notes)
        }
        other => root.fail(format!(
            "no counterpart of the engine {other:?}; choose a file of EngineSimple, EngineSimpleMap or EngineShafts with --engine"
        )),
    }
}

/// An engine with a torque for either end of the throttle.
fn map(node: &Node, doc: &Doc, notes: &mut Notes) -> Result<Engine, ImportError> {
    let most = rad(node.num("Maximal Engine Speed RPM")?);
    let mut full = curve(&node.need("Map Full Throttle")?)?;
    let closed = curve(&node.need("Map Zero Throttle")?)?;
    if full == closed {
        notes.approximated(format!(
            "{}: both maps are equal, so the throttle has no effect, as in Chrono; give another engine with --engine",
            doc.file
        ));
    }
    end(&mut full, most, doc, notes);
    Ok(Engine::Map { full_throttle: full, closed_throttle: closed, inertia: 0.0 })
}

/// An engine with a torque at full throttle and losses.
fn lossy(node: &Node, inertia: f64, doc: &Doc, notes: &mut Notes) -> Result<Engine, ImportError> {
    let (torque, losses) = (curve(&node.need("Torque Map")?)?, curve(&node.need("Losses Map")?)?);
    let mut speeds: Vec<f64> = torque.iter().chain(&losses).map(|p| p[0]).collect();
    speeds.sort_by(f64::total_cmp);
    speeds.dedup();
    let full = speeds.iter().map(|s| [*s, interpolate(&torque, *s).0 + interpolate(&losses, *s).0]).collect();
    notes
        .approximated(format!("{}: torque at full throttle is the torque map with the losses map", doc.file));
    Ok(Engine::Map { full_throttle: full, closed_throttle: losses, inertia })
}

/// Ends a map that pushes at its last speed: nothing would limit that engine.
fn end(full: &mut Vec<[f64; 2]>, most: f64, doc: &Doc, notes: &mut Notes) {
    let last = full[full.len() - 1];
    if last[1] <= 0.0 {
        return;
    }
    let at = most.max(full[0][0] + 1.0);
    let torque = interpolate(full, at).0;
    full.retain(|p| p[0] < at);
    full.push([at, torque]);
    full.push([1.03 * at, -0.3 * torque]);
    notes.approximated(format!(
        "{}: beyond the maximal engine speed the torque falls to a brake torque of 30 %",
        doc.file
    ));
}

/// A transmission with what it adds to the engine's and the driveline's shafts, kg m².
#[derive(Clone, Debug)]
pub(crate) struct Transmission {
    pub(crate) gearbox: Gearbox,
    pub(crate) converter: Option<Converter>,
    pub(crate) engine_inertia: f64,
    pub(crate) shaft_inertia: f64,
}

/// Reads a transmission, or that of a powertrain of Chrono 8 and before. `engine` gives shift speeds where the file has none.
pub(crate) fn transmission(
    doc: &Doc,
    engine: &Engine,
    notes: &mut Notes,
) -> Result<Transmission, ImportError> {
    let root = doc.root();
    let name = template(doc)?;
    let gears = match name.as_str() {
        "SimplePowertrain" | "SimpleCVTPowertrain" => root.clone(),
        "SimpleMapPowertrain" | "ShaftsPowertrain" => root.need("Transmission")?,
        _ => root.need("Gear Box")?,
    };
    let top = top_speed(engine);
    let mut out = Transmission {
        gearbox: Gearbox {
            ratios: Vec::new(),
            reverse: None,
            direction_change: DirectionChange::default(),
            shift_down: Vec::new(),
            shift_up: Vec::new(),
            shift_time: 0.0,
            latency: 0.0,
            load_sensing: false,
        },
        converter: None,
        engine_inertia: 0.0,
        shaft_inertia: 0.0,
    };
    let g = &mut out.gearbox;
    notes.assumed("powertrain.gearbox.direction_change: 0.5 m/s and 0.5 s".to_owned());
    match name.as_str() {
        "SimplePowertrain" | "SimpleCVTPowertrain" => {
            let (forward, reverse) = (gears.num("Forward Gear Ratio")?, gears.num("Reverse Gear Ratio")?);
            (g.ratios, g.reverse) = (vec![forward.abs()], Some(-reverse.abs()).filter(|r| *r != 0.0));
            (g.shift_down, g.shift_up) = (vec![0.0], vec![2.0 * top]);
        }
        "AutomaticTransmissionSimpleMap" | "SimpleMapPowertrain" => {
            (g.ratios, g.reverse) = ratios(&gears)?;
            let node = gears.need("Shift Points Map RPM")?;
            let mut points = node.table()?;
            if points.len() < g.ratios.len() {
                return node.fail(format!(
                    "{} pairs for {} gears; give the speeds of shifting down and up for each gear",
                    points.len(),
                    g.ratios.len()
                ));
            }
            if points.len() > g.ratios.len() {
                notes.dropped(format!(
                    "{}: the pairs after the first {}, one for each gear",
                    node.at(),
                    g.ratios.len()
                ));
                points.truncate(g.ratios.len());
            }
            g.shift_down = points.iter().map(|p| rad(p[0])).collect();
            g.shift_up = points.iter().map(|p| rad(p[1])).collect();
        }
        "AutomaticTransmissionShafts" | "ShaftsPowertrain" => {
            (g.ratios, g.reverse) = ratios(&gears)?;
            let (up, down) = (rad(gears.num("Upshift RPM")?), rad(gears.num("Downshift RPM")?));
            g.shift_up = vec![up; g.ratios.len()];
            g.shift_down = vec![down; g.ratios.len()];
            g.latency = gears.num_or("Shift Latency", 1.0)?;
            out.converter = converter(&root, notes)?;
            [out.engine_inertia, out.shaft_inertia] = if name == "ShaftsPowertrain" {
                [0.0, gears.num_or("Output Shaft Inertia", 0.0)?]
            } else {
                shafts(&root)?
            };
        }
        "ManualTransmissionShafts" => {
            (g.ratios, g.reverse) = ratios(&gears)?;
            g.shift_up = vec![0.85 * top; g.ratios.len()];
            g.shift_down = vec![0.4 * top; g.ratios.len()];
            g.shift_time = 0.3;
            notes.approximated(format!(
                "{}: the manual transmission shifts by itself, up at 85 % and down at 40 % of the engine's top speed, in 0.3 s",
                doc.file
            ));
            [out.engine_inertia, out.shaft_inertia] = shafts(&root)?;
        }
        "AutomaticTransmissionSimpleCVT" => {
            let (least, most) = (gears.num("Minimum Gear Ratio")?, gears.num("Maximum Gear Ratio")?);
            if !(least > 0.0 && most > least) {
                return gears.fail(format!(
                    "gear ratios from {least} to {most}; both must be positive, the minimum first"
                ));
            }
            let step = vb_math::pow(most / least, 1.0 / (STEPS - 1) as f64);
            g.ratios = std::iter::successors(Some(least), |r| Some(r * step)).take(STEPS).collect();
            g.reverse = Some(-least);
            g.shift_up = vec![0.8 * top; STEPS];
            g.shift_down = vec![0.8 * top / (step * 1.3); STEPS];
            notes.approximated(format!(
                "{}: the variable ratio is {STEPS} gears with equal steps; reverse is the lowest of them",
                doc.file
            ));
        }
        other => {
            return root.fail(format!(
                "no counterpart of the transmission {other:?}; choose a file of AutomaticTransmissionSimpleMap, \
                 AutomaticTransmissionShafts, AutomaticTransmissionSimpleCVT or ManualTransmissionShafts with --transmission"
            ));
        }
    }
    for k in 0..g.ratios.len() {
        if g.shift_up[k] <= g.shift_down[k] {
            return gears.fail(format!(
                "gear {} shifts up at {:.0} rad/s and down at {:.0}; up must be faster",
                k + 1,
                g.shift_up[k],
                g.shift_down[k]
            ));
        }
    }
    Ok(out)
}

/// Inertias on the engine's and on the driveline's side, kg m².
fn shafts(root: &Node) -> Result<[f64; 2], ImportError> {
    Ok([root.num_or("Motorshaft Inertia", 0.0)?, root.num_or("Driveshaft Inertia", 0.0)?])
}

/// Forward ratios, the lowest gear first, and the reverse one.
fn ratios(gears: &Node) -> Result<(Vec<f64>, Option<f64>), ImportError> {
    let node = gears.need("Forward Gear Ratios")?;
    let mut forward = node.numbers()?;
    forward.sort_by(f64::total_cmp);
    if forward.first().is_none_or(|r| *r <= 0.0) {
        return node.fail("positive ratios, output over input speed, are expected");
    }
    let reverse = gears.get("Reverse Gear Ratio").map(|n| n.number()).transpose()?;
    Ok((forward, reverse.map(|r| -r.abs()).filter(|r| *r != 0.0)))
}

fn converter(root: &Node, notes: &mut Notes) -> Result<Option<Converter>, ImportError> {
    let Some(node) = root.get("Torque Converter") else { return Ok(None) };
    let tidy = |key: &str| -> Result<Vec<[f64; 2]>, ImportError> {
        let n = node.need(key)?;
        let mut t = n.table()?;
        t.retain(|p| (0.0..=1.0).contains(&p[0]));
        t.sort_by(|a, b| a[0].total_cmp(&b[0]));
        t.dedup_by(|a, b| a[0] == b[0]);
        if t.is_empty() { n.fail("has no point with a speed ratio of 0 to 1") } else { Ok(t) }
    };
    let capacity = tidy("Capacity Factor Map")?;
    let mut torque_ratio = tidy("Torque Ratio Map")?;
    for p in &mut torque_ratio {
        if p[0] * p[1] > 1.0 {
            notes.approximated(format!(
                "{}: a torque ratio of {} at the speed ratio {} gives more power than it takes; it is cut",
                node.at(),
                p[1],
                p[0]
            ));
            p[1] = 1.0 / p[0];
        }
    }
    notes.assumed("powertrain.converter.idle_speed: 650 rpm".to_owned());
    Ok(Some(Converter { idle_speed: IDLE, capacity, torque_ratio, lock_up: None }))
}

/// The speed beyond which an engine does not push, rad/s.
pub(crate) fn top_speed(engine: &Engine) -> f64 {
    match engine {
        Engine::Simple { max_speed, .. } => *max_speed,
        Engine::Map { full_throttle: t, .. } | Engine::Electric { torque: t, .. } => {
            let crossing = t.windows(2).find(|w| w[0][1] > 0.0 && w[1][1] <= 0.0);
            let at = |w: &[[f64; 2]]| w[0][0] + (w[1][0] - w[0][0]) * w[0][1] / (w[0][1] - w[1][1]);
            crossing.map_or(t[t.len() - 1][0], at)
        }
    }
}

/// The greatest power of an engine, W, also between the points of its table.
pub(crate) fn power(engine: &Engine) -> f64 {
    match engine {
        Engine::Simple { power, .. } => *power,
        Engine::Map { full_throttle: t, .. } | Engine::Electric { torque: t, .. } => {
            let pieces = t.windows(2).map(|w| {
                let ([v, a], [end, b]) = (w[0], w[1]);
                let slope = (b - a) / (end - v);
                // Where the power of a straight piece has no slope.
                let top = if slope < 0.0 { (0.5 * (v - a / slope)).clamp(v, end) } else { end };
                top * (a + slope * (top - v))
            });
            pieces.chain(t.iter().map(|[v, torque]| v * torque)).fold(0.0, f64::max)
        }
    }
}

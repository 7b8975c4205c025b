//! Drivelines.

use super::json::{Doc, Node};
use super::set::template;
use crate::{ImportError, Notes};
use vb_vehicle::powertrain::{Differential, Driveline, DrivenAxle};

/// Reads a driveline for this number of driven axles.
pub(crate) fn read(doc: &Doc, driven: usize, notes: &mut Notes) -> Result<Driveline, ImportError> {
    let root = doc.root();
    let count = |n: usize| -> Result<(), ImportError> {
        if driven == n {
            return Ok(());
        }
        root.fail(format!(
            "drives {n} axles, but the vehicle's file lists {driven} suspension indexes; correct one of them"
        ))
    };
    root.get("Shaft Direction").inspect(Node::used);
    match template(doc)?.as_str() {
        "ShaftsDriveline2WD" => {
            count(1)?;
            let (inertia, gears) = (root.need("Shaft Inertia")?, root.need("Gear Ratio")?);
            symmetric(&gears, &["Differential"], notes)?;
            let axle = DrivenAxle {
                fraction: 1.0,
                final_drive: gears.num("Conical Gear")?.abs(),
                shaft_inertia: 0.0,
                box_inertia: inertia.num("Differential Box")?,
                differential: clutch(&root, "Axle Differential Locking Limit", notes)?,
            };
            Ok(Driveline { shaft_inertia: inertia.num("Driveshaft")?, centre: Differential::Open {}, axles: vec![axle] })
        }
        "ShaftsDriveline4WD" => {
            count(2)?;
            let (inertia, gears) = (root.need("Shaft Inertia")?, root.need("Gear Ratio")?);
            symmetric(&gears, &["Central Differential", "Front Differential", "Rear Differential"], notes)?;
            let differential = clutch(&root, "Axle Differential Locking Limit", notes)?;
            let axle = |side: &str| -> Result<DrivenAxle, ImportError> {
                Ok(DrivenAxle {
                    fraction: 0.5,
                    final_drive: gears.num(&format!("{side} Conical Gear"))?.abs(),
                    shaft_inertia: inertia.num(&format!("{side} Driveshaft"))?,
                    box_inertia: inertia.num(&format!("{side} Differential Box"))?,
                    differential,
                })
            };
            Ok(Driveline {
                shaft_inertia: inertia.num("Driveshaft")? + inertia.num("Central Differential Box")?,
                centre: clutch(&root, "Central Differential Locking Limit", notes)?,
                axles: vec![axle("Front")?, axle("Rear")?],
            })
        }
        "SimpleDriveline" => {
            let front = fraction(&root)?;
            let sides = [("Front", front), ("Rear", 1.0 - front)];
            let sides: Vec<_> = sides.into_iter().filter(|(_, f)| *f > 0.0).collect();
            count(sides.len())?;
            let axle = |(side, fraction): &(&str, f64)| -> Result<DrivenAxle, ImportError> {
                Ok(DrivenAxle {
                    fraction: *fraction,
                    final_drive: root.num_or(&format!("{side} Conical Gear Ratio"), 1.0)?.abs(),
                    shaft_inertia: 0.0,
                    box_inertia: 0.0,
                    differential: slip(root.num(&format!("{side} Differential Max Bias"))?),
                })
            };
            let axles = sides.iter().map(axle).collect::<Result<_, _>>()?;
            Ok(massless(axles, notes, doc))
        }
        "SimpleDrivelineXWD" => {
            let differential = slip(root.num("Differential Max Bias")?);
            let fraction = 1.0 / driven.max(1) as f64;
            let axle = DrivenAxle { fraction, final_drive: 1.0, shaft_inertia: 0.0, box_inertia: 0.0, differential };
            Ok(massless(vec![axle; driven], notes, doc))
        }
        "SimpleTrackDriveline" => {
            count(1)?;
            let differential = slip(root.num("Differential Max Bias")?);
            let axle = DrivenAxle { fraction: 1.0, final_drive: 1.0, shaft_inertia: 0.0, box_inertia: 0.0, differential };
            Ok(massless(vec![axle], notes, doc))
        }
        "TrackDrivelineBDS" => {
            count(1)?;
            let axle = DrivenAxle {
                fraction: 1.0,
                final_drive: root.num("Conical Gear Ratio")?.abs(),
                shaft_inertia: 0.0,
                box_inertia: root.num("Differential Box Inertia")?,
                differential: Differential::Open {},
            };
            Ok(Driveline { shaft_inertia: root.num("Driveshaft Inertia")?, centre: Differential::Open {}, axles: vec![axle] })
        }
        other => root.fail(format!(
            "no counterpart of the driveline {other:?}; use ShaftsDriveline2WD, ShaftsDriveline4WD, SimpleDriveline, \
             SimpleDrivelineXWD, SimpleTrackDriveline or TrackDrivelineBDS"
        )),
    }
}

/// The part of the torque that a simple driveline sends to the front.
fn fraction(root: &Node) -> Result<f64, ImportError> {
    let node = root.need("Front Torque Fraction")?;
    let x = node.number()?;
    if (0.0..=1.0).contains(&x) { Ok(x) } else { node.fail(format!("{x} is not between 0 and 1")) }
}

/// Takes the axle to which a simple driveline sends no torque off the driven ones.
pub(crate) fn undriven(doc: &Doc, driven: &mut Vec<usize>, notes: &mut Notes) -> Result<(), ImportError> {
    if template(doc)? != "SimpleDriveline" || driven.len() != 2 {
        return Ok(());
    }
    let front = fraction(&doc.root())?;
    if front == 0.0 || front == 1.0 {
        let out = driven.remove(usize::from(front == 1.0));
        notes.chosen(format!("{}: axle {out} gets no torque, so it is not driven", doc.file));
    }
    Ok(())
}

/// Simple drivelines split torques and have no masses.
fn massless(axles: Vec<DrivenAxle>, notes: &mut Notes, doc: &Doc) -> Driveline {
    if axles.len() > 1 {
        notes.approximated(format!(
            "{}: the fixed split of torque between the axles is an open centre differential",
            doc.file
        ));
    }
    Driveline { shaft_inertia: 0.0, centre: Differential::Open {}, axles }
}

fn slip(bias: f64) -> Differential {
    if bias > 1.0 { Differential::LimitedSlip { bias, preload: 0.0 } } else { Differential::Open {} }
}

/// The clutch that limits the difference between outputs; Chrono's default is 100 N m.
fn clutch(root: &Node, key: &str, notes: &mut Notes) -> Result<Differential, ImportError> {
    let torque = match root.get(key) {
        Some(n) => n.number()?,
        None => {
            notes.chosen(format!("{}: {key:?} is absent, so it is 100 N m, as in Chrono", root.doc().file));
            100.0
        }
    };
    Ok(if torque > 0.0 { Differential::Clutch { torque } } else { Differential::Open {} })
}

/// Differentials of the simulator split evenly: −1 in Chrono.
fn symmetric(gears: &Node, keys: &[&str], notes: &mut Notes) -> Result<(), ImportError> {
    for key in keys {
        if let Some(n) = gears.get(key)
            && n.number()? != -1.0
        {
            notes.approximated(format!("{}: an even differential, -1, is used", n.at()));
        }
    }
    Ok(())
}

//! Vehicles on wheels.

use super::finish::{self, Draft};
use super::json::{Doc, Node};
use super::parts::Parts;
use super::set::Set;
use super::steering::Gear;
use super::{chassis, choice, driveline, steering, suspension, tyre};
use crate::place::{Mass, add};
use crate::{ImportError, Notes, Options};
use std::rc::Rc;
use vb_vehicle::powertrain::Powertrain;
use vb_vehicle::suspension::{AntiRoll, Part, SteeredBy, Steering};
use vb_vehicle::{Axle, GRAVITY, MAX_WHEELS, Point, VehicleSpec};

pub(super) fn convert(
    set: &Set,
    vehicle: &Rc<Doc>,
    options: &Options,
    notes: &mut Notes,
) -> Result<VehicleSpec, ImportError> {
    let root = vehicle.root();
    for key in ["Rear Chassis", "Chassis Connectors", "Subchassis"] {
        if let Some(n) = root.get(key) {
            return n.fail(
                "articulated vehicles and subchassis have no counterpart; convert a vehicle with one chassis",
            );
        }
    }
    let body = set.follow(&root.need("Chassis")?.need("Input File")?, &["Chassis"])?;
    let body = chassis::read(set, &body.root(), notes)?;
    let mut sprung = body.mass;
    let gears = gears(set, &root, &mut sprung, notes)?;
    let entries = root.need("Axles")?;
    let items = entries.items()?;
    if !(2..=MAX_WHEELS / 2).contains(&items.len()) {
        return entries.fail(format!(
            "{} axles; the simulator has vehicles with 2 to {}",
            items.len(),
            MAX_WHEELS / 2
        ));
    }
    let Some(line) = root.get("Driveline") else {
        return root.fail("\"Driveline\" is missing; a vehicle without drive has no counterpart");
    };
    let mut driven: Vec<usize> = indexes(&line.need("Suspension Indexes")?, items.len())?;
    let line = set.follow(&line.need("Input File")?, &["Driveline"])?;
    driveline::undriven(&line, &mut driven, notes)?;
    let mut axles = Vec::new();
    for (i, entry) in items.iter().enumerate() {
        axles.push(axle(set, entry, &gears, i, &items, &mut sprung, notes)?);
    }
    for (i, a) in axles.iter_mut().enumerate() {
        a.driven = driven.contains(&i);
    }
    declared(&root, notes)?;
    // Tyres: their masses count in the loads from which some of their values follow.
    let files = choice::tyres(set, options, axles.len(), notes)?;
    let mut twins = Vec::new();
    for ((a, f), entry) in axles.iter_mut().zip(&files).zip(&items) {
        let separation = entry.get("Wheel Separation").map(|n| n.number()).transpose()?;
        a.unsprung_mass += tyre::mass(f)? * if separation.is_some() { 2.0 } else { 1.0 };
        twins.push(separation);
    }
    let beams: f64 = axles.iter().filter_map(|a| a.suspension.linkage.beam()).map(|b| b.mass).sum();
    let total = sprung.mass + axles.iter().map(|a| 2.0 * a.unsprung_mass).sum::<f64>() + beams;
    let load = total * GRAVITY / (2 * axles.len()) as f64;
    let mut tyres = Vec::new();
    for ((a, f), separation) in axles.iter_mut().zip(&files).zip(twins) {
        let t = match separation {
            None => tyre::read(set, f, load, notes)?,
            Some(d) => {
                notes.approximated(format!(
                    "axle {}: dual wheels are one wheel with twice the forces of a tyre, {d} m wider than it",
                    a.name
                ));
                tyre::twin(tyre::read(set, f, 0.5 * load, notes)?, d)
            }
        };
        a.spin_inertia += t.spin;
        tyres.push(t.spec);
    }
    let choice::Powertrain { engine, transmission } = choice::powertrain(set, options, notes)?;
    let mut driveline = driveline::read(&line, driven.len(), notes)?;
    driveline.shaft_inertia += transmission.shaft_inertia;
    order(&mut axles, &mut tyres, &mut driveline.axles, notes);
    notes.assumed("steering.rate: 2 per second, without a limit of force".to_owned());
    let powertrain = Powertrain {
        engine,
        converter: transmission.converter,
        gearbox: transmission.gearbox,
        driveline,
        governor: None,
    };
    finish::wheeled(
        Draft {
            name: root.get("Name").map(|n| n.text()).transpose()?.unwrap_or("vehicle").to_owned(),
            sprung,
            seat: body.seat,
            hull: body.hull,
            friction: body.friction,
            axles,
            tyres,
            steering: Steering { rate: 2.0, force: None, torque: None, by: SteeredBy::Wheels },
            skid: None,
            tracks: None,
            powertrain,
        },
        options,
        notes,
    )
}

/// Declarations of the whole, which follow from the geometry here.
fn declared(root: &Node, notes: &mut Notes) -> Result<(), ImportError> {
    for key in
        ["Wheelbase", "Minimum Turning Radius", "Maximum Steering Angle (deg)", "Maximum Steering Angle"]
    {
        if let Some(n) = root.get(key) {
            notes.dropped(format!("{}: {}, which follows from the geometry here", n.at(), n.number()?));
        }
    }
    Ok(())
}

fn indexes(node: &Node, axles: usize) -> Result<Vec<usize>, ImportError> {
    let mut out = Vec::new();
    for n in node.items()? {
        node.used();
        let x = n.number()?;
        let k = x as usize;
        if x < 0.0 || k as f64 != x || k >= axles {
            return n.fail(format!("axle {x} does not exist; there are {axles}, counted from 0"));
        }
        out.push(k);
    }
    Ok(out)
}

fn gears(set: &Set, root: &Node, sprung: &mut Mass, notes: &mut Notes) -> Result<Vec<Gear>, ImportError> {
    let mut gears = Vec::new();
    let Some(list) = root.get("Steering Subsystems") else { return Ok(gears) };
    for entry in list.items()? {
        let doc = set.follow(&entry.need("Input File")?, &["Steering"])?;
        let gear = steering::read(&doc.root(), &entry, notes)?;
        for (mass, at) in &gear.masses {
            *sprung = sprung.plus(&Mass::point(*mass, *at));
        }
        gears.push(gear);
    }
    Ok(gears)
}

/// The file at both sides of an axle; the right one must say the same.
fn both(
    set: &Set,
    entry: &Node,
    part: &str,
    kind: &str,
    notes: &mut Notes,
) -> Result<Option<Rc<Doc>>, ImportError> {
    let Some(left) = entry.get(&format!("Left {part} Input File")) else { return Ok(None) };
    if let Some(right) = entry.get(&format!("Right {part} Input File"))
        && right.text()? != left.text()?
    {
        set.follow(&right, &[kind])?;
        notes.approximated(format!("{}: both sides have the left one's {part}", right.at()));
    }
    set.follow(&left, &[kind]).map(Some)
}

fn axle(
    set: &Set,
    entry: &Node,
    gears: &[Gear],
    index: usize,
    all: &[Node],
    sprung: &mut Mass,
    notes: &mut Notes,
) -> Result<Axle, ImportError> {
    let doc = set.follow(&entry.need("Suspension Input File")?, &["Suspension"])?;
    let position = entry.pt("Suspension Location")?;
    let mut parts = suspension::read(&doc.root(), notes)?;
    for (mass, at) in &parts.sprung {
        *sprung = sprung.plus(&Mass::point(*mass, add(*at, position)));
    }
    let steering = match entry.get("Steering Index") {
        None => None,
        // Chrono's value for none.
        Some(n) if n.number()? == -1.0 => None,
        Some(n) => {
            let k = indexes_one(&n, gears.len())?;
            Some(gears[k].at(position, parts.mirrored))
        }
    };
    if parts.struts.len() + usize::from(parts.linkage.torsion().is_some()) > 2 {
        return doc.root().fail(
            "more than two springs and shocks on lines of their own; the simulator has two for each wheel",
        );
    }
    let (mut mass, mut spin) = (parts.unsprung, parts.spin);
    for part in ["Wheel", "Inside Wheel", "Outside Wheel"] {
        if let Some(w) = both(set, entry, part, "Wheel", notes)? {
            mass += w.root().num("Mass")?;
            spin += w.root().pt("Inertia")?[1];
        }
    }
    let brake = match both(set, entry, "Brake", "Brake", notes)? {
        Some(b) => b.root().num("Maximum Torque")?,
        None => 0.0,
    };
    if let Some(n) = entry.get("Antirollbar Input File") {
        let doc = set.follow(&n, &["Antirollbar"])?;
        parts.anti_roll = Some(bar(&doc, entry, position, &parts, sprung)?);
    }
    let name = match (index, all.len()) {
        (0, _) => "front".to_owned(),
        (k, n) if k + 1 == n => "rear".to_owned(),
        (1, 3) => "middle".to_owned(),
        (k, _) => format!("axle{}", k + 1),
    };
    Ok(Axle {
        name,
        position,
        steering,
        driven: false,
        unsprung_mass: mass,
        spin_inertia: spin,
        brake_torque: brake,
        suspension: finish::sprung(parts),
        tyre: None,
        tyres: std::collections::BTreeMap::new(),
    })
}

fn indexes_one(node: &Node, count: usize) -> Result<usize, ImportError> {
    let x = node.number()?;
    let found = (0..count).find(|k| {
        let k = *k as f64;
        k == x
    });
    found.ok_or_else(|| {
        node.error(format!("steering subsystem {x} does not exist; there are {count}, counted from 0"))
    })
}

/// An anti-roll bar of two arms with a torsion spring between them.
fn bar(
    doc: &Doc,
    entry: &Node,
    axle: Point,
    parts: &Parts,
    sprung: &mut Mass,
) -> Result<AntiRoll, ImportError> {
    let root = doc.root();
    let at = entry.pt("Antirollbar Location")?;
    let (arm, spring) = (root.need("Arm")?, root.need("RSD")?);
    let (length, width) = (arm.num("Length")?, arm.num("Width")?);
    let height = root.need("Droplink")?.num("Height")?;
    let mass = arm.num_or("Mass", 0.0)?;
    for side in [1.0, -1.0] {
        *sprung = sprung.plus(&Mass::point(mass, add(at, [0.0, 0.5 * side * length, 0.0])));
    }
    let place = |p: Point| crate::place::sub(add(at, p), axle);
    Ok(AntiRoll::Bar {
        stiffness: spring.num("Spring Coefficient")?,
        damping: spring.num_or("Damping Coefficient", 0.0)?,
        pivot: place([0.0, length, 0.0]),
        arm_end: place([width, length, 0.0]),
        link_end: place([width, length, height]),
        part: parts.bar.unwrap_or(Part::Upright),
    })
}

/// Orders axles from front to back, with their tyres and drives.
fn order(
    axles: &mut Vec<Axle>,
    tyres: &mut Vec<vb_vehicle::TyreSpec>,
    drives: &mut Vec<vb_vehicle::powertrain::DrivenAxle>,
    notes: &mut Notes,
) {
    let ahead = |a: &Axle| a.position[0] + a.suspension.linkage.spindle()[0];
    if axles.is_sorted_by(|a, b| ahead(a) > ahead(b)) {
        return;
    }
    let mut drives_left = std::mem::take(drives).into_iter();
    let mut all: Vec<_> = axles
        .drain(..)
        .zip(tyres.drain(..))
        .map(|(a, t)| {
            let drive = if a.driven { drives_left.next() } else { None };
            (a, t, drive)
        })
        .collect();
    all.sort_by(|a, b| ahead(&b.0).total_cmp(&ahead(&a.0)));
    for (a, t, d) in all {
        axles.push(a);
        tyres.push(t);
        drives.extend(d);
    }
    notes.chosen("axles are listed from front to back, other than in the vehicle's file");
}

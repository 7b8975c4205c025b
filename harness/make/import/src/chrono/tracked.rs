//! Vehicles on tracks.

use super::finish::{self, Draft};
use super::json::{Doc, Node};
use super::set::Set;
use super::strut::{rates, turned};
use super::{chassis, choice, driveline};
use crate::place::{Mass, add, mirrored};
use crate::{ImportError, Notes, Options};
use std::rc::Rc;
use vb_vehicle::powertrain::Powertrain;
use vb_vehicle::suspension::{
    Damper, Linkage, Part, RigidMount, SteeredBy, Steering, Stops, Strut, Suspension, Torsion, TorsionArm,
};
use vb_vehicle::tracks::Tracks;
use vb_vehicle::tyre::{HardContact, RigidTyre};
use vb_vehicle::{Axle, GRAVITY, MAX_WHEELS, Point, TyreSpec, VehicleSpec};

/// Tension of a belt over the vehicle's weight (Wong, Theory of Ground Vehicles, 2008, ch. 4).
const TENSION: f64 = 0.1;
/// Shear of the pads up to full friction, m, as of the shipped M113.
const SHEAR: f64 = 0.075;

/// Types of a road wheel's suspension; the second is that of Chrono 6 and before.
const SUSPENSION: &[&str] = &["TrackSuspension", "RoadWheelAssembly"];

/// A belt: thickness, width and friction of its shoes, and its mass.
struct Belt {
    thickness: f64,
    width: f64,
    friction: f64,
    mass: f64,
}

/// A wheel of a track: its place in the plane of the track, radius, mass and spin inertia.
struct Wheel {
    name: String,
    at: Point,
    radius: f64,
    mass: f64,
    spin: f64,
    /// The arm that carries it; a sprocket or an idler has none.
    arm: Option<Suspension>,
    brake: f64,
}

pub(super) fn convert(
    set: &Set,
    vehicle: &Rc<Doc>,
    options: &Options,
    notes: &mut Notes,
) -> Result<VehicleSpec, ImportError> {
    let root = vehicle.root();
    let body = set.follow(&root.need("Chassis")?.need("Input File")?, &["Chassis"])?;
    let body = chassis::read(set, &body.root(), notes)?;
    let mut sprung = body.mass;
    let list = root.need("Track Assemblies")?;
    let entries = list.items()?;
    let [left, right] = &entries[..] else {
        return list.fail(format!("{} assemblies; two are expected", entries.len()));
    };
    let offset = left.num("Offset")?.abs();
    if (right.num("Offset")?.abs() - offset).abs() > 1e-6 {
        notes.approximated(format!("{}: both tracks are {offset} m from the middle", right.at()));
    }
    let docs = [left, right].map(|e| set.follow(&e.need("Input File")?, &["TrackAssembly"]));
    let [left, right] = docs;
    let (left, right) = (left?, right?);
    let (mut wheels, belt, tensioner) = assembly(set, &left.root(), offset, &mut sprung, notes)?;
    same(set, &right.root(), &mut wheels, notes)?;
    wheels.sort_by(|a, b| b.at[0].total_cmp(&a.at[0]));
    if wheels.len() > MAX_WHEELS / 2 {
        return left.root().fail(format!(
            "{} wheels to a side; the simulator has {} at most",
            wheels.len(),
            MAX_WHEELS / 2
        ));
    }
    let ends = |w: &Wheel| w.arm.is_none();
    if !ends(&wheels[0]) || !ends(&wheels[wheels.len() - 1]) {
        return left.root().fail("sprocket and idler must lie before and behind all road wheels");
    }
    // The belt's weight: half on the ground under the road wheels, a quarter above on the chassis, an eighth at either end.
    let roads = (wheels.len() - 2) as f64;
    for w in &mut wheels {
        w.mass += if w.arm.is_some() { 0.5 * belt.mass / roads } else { 0.125 * belt.mass };
    }
    for side in [offset, -offset] {
        let top = wheels.iter().map(|w| w.at[2] + w.radius).fold(f64::NEG_INFINITY, f64::max);
        let x = 0.5 * (wheels[0].at[0] + wheels[wheels.len() - 1].at[0]);
        sprung = sprung.plus(&Mass::point(0.25 * belt.mass, [x, side, top]));
    }
    notes.approximated("belts are continuous: they have the mass of their shoes, half of it on the road wheels, a quarter on the chassis");
    let total = sprung.mass + 2.0 * wheels.iter().map(|w| w.mass).sum::<f64>();
    let spacing = spacing(&wheels);
    let load = total * GRAVITY / (2.0 * roads);
    let tyre = |w: &Wheel| pad(w.radius, &belt, load, spacing, w.mass);
    let tyres: Vec<TyreSpec> = wheels.iter().map(|w| TyreSpec::Rigid(tyre(w))).collect();
    notes.assumed("contact of the belts: 5.5 mm deep at rest, pads that shear by 75 mm up to full friction, as of the shipped M113");
    let sprocket = wheels.iter().position(|w| w.brake > 0.0).unwrap_or(0);
    let needed = 1.2 * belt.friction * 0.5 * total * GRAVITY * wheels[sprocket].radius;
    let steering_torque = wheels[sprocket].brake.max(needed);
    notes.approximated(format!(
        "steering: a brake of {steering_torque:.0} N m on the inner sprocket, enough to lock its belt; Chrono's brakes have {:.0} N m",
        wheels[sprocket].brake
    ));
    let tracks = Tracks {
        thickness: belt.thickness,
        mass: belt.mass,
        tension: TENSION * total * GRAVITY,
        stiffness: 0.25 * tensioner[0],
        damping: 0.25 * tensioner[1],
        resistance: [0.0136, 0.000_917],
        steering_torque,
    };
    notes.assumed("tracks.tension: a tenth of the weight; tracks.resistance: rubber-bushed tracks (both Wong, Theory of Ground Vehicles, 2008, ch. 4)");
    let line = set.follow(&root.need("Driveline")?.need("Input File")?, &["TrackDriveline"])?;
    let mut driveline = driveline::read(&line, 1, notes)?;
    let choice::Powertrain { engine, transmission } = choice::powertrain(set, options, notes)?;
    driveline.shaft_inertia += transmission.shaft_inertia;
    let powertrain = Powertrain {
        engine,
        converter: transmission.converter,
        gearbox: transmission.gearbox,
        driveline,
        governor: None,
    };
    let road: Vec<&Wheel> = wheels.iter().filter(|w| w.arm.is_some()).collect();
    let origin = [0.5 * (road[0].at[0] + road[road.len() - 1].at[0]), 0.0, road[0].at[2]];
    let axles = wheels.iter().enumerate().map(|(i, w)| axle(w, i == sprocket, offset)).collect();
    notes.assumed("steering.rate: 2 per second");
    let draft = Draft {
        name: root.get("Name").map(|n| n.text()).transpose()?.unwrap_or("tracked").to_owned(),
        sprung,
        seat: body.seat,
        hull: body.hull,
        friction: body.friction,
        axles,
        tyres,
        steering: Steering { rate: 2.0, force: None, torque: None, by: SteeredBy::Differential },
        skid: None,
        tracks: Some(tracks),
        powertrain,
    };
    let mut spec = finish::build(draft, origin, options, notes)?;
    // The tyre of most wheels is the vehicle's own.
    if let Some(road) = spec.axles.iter().position(|a| !matches!(a.suspension.linkage, Linkage::Rigid(_))) {
        let common = spec.tyre_of(&spec.axles[road]).clone();
        let own: Vec<TyreSpec> = spec.axles.iter().map(|a| spec.tyre_of(a).clone()).collect();
        for (a, t) in spec.axles.iter_mut().zip(own) {
            a.tyre = (t != common).then_some(t);
        }
        spec.tyre = common;
    }
    ranges(&mut spec, load, notes)?;
    Ok(spec)
}

fn spacing(wheels: &[Wheel]) -> f64 {
    let road: Vec<f64> = wheels.iter().filter(|w| w.arm.is_some()).map(|w| w.at[0]).collect();
    let gaps = (road.len().max(2) - 1) as f64;
    ((road[0] - road[road.len() - 1]) / gaps).max(0.05)
}

fn pad(radius: f64, belt: &Belt, load: f64, spacing: f64, mass: f64) -> RigidTyre {
    let vertical_stiffness = load / 0.0055;
    let tangential_stiffness = belt.friction * load / SHEAR;
    RigidTyre {
        radius,
        width: belt.width,
        friction: belt.friction,
        vertical_stiffness,
        vertical_damping: 2.0 * (vertical_stiffness * mass).sqrt(),
        tangential_stiffness,
        tangential_damping: 0.126 * tangential_stiffness,
        relaxation_length: spacing,
        contact: HardContact::Envelope,
        dilation: None,
    }
}

fn axle(w: &Wheel, driven: bool, offset: f64) -> Axle {
    let rigid = || Suspension {
        linkage: Linkage::Rigid(RigidMount { spindle: [0.0, offset, 0.0] }),
        range: [0.0; 2],
        struts: Vec::new(),
        stops: None,
        anti_roll: None,
    };
    Axle {
        name: w.name.clone(),
        position: [w.at[0], 0.0, w.at[2]],
        steering: None,
        driven,
        unsprung_mass: w.mass,
        spin_inertia: w.spin,
        brake_torque: w.brake,
        suspension: w.arm.clone().unwrap_or_else(rigid),
        tyre: None,
        tyres: std::collections::BTreeMap::new(),
    }
}

/// Stops for arms; range until the linkage closes.
fn ranges(spec: &mut VehicleSpec, load: f64, notes: &mut Notes) -> Result<(), ImportError> {
    for a in &mut spec.axles {
        let Linkage::TorsionArm(arm) = &a.suspension.linkage else { continue };
        let reach = crate::place::length(crate::place::sub(
            arm.spindle,
            [arm.pivot[0], arm.spindle[1], arm.pivot[2]],
        ));
        let mut up = 0.45 * reach;
        loop {
            a.suspension.range = [-0.7 * up, up];
            match vb_vehicle::kinematics::AxleKinematics::solve(a) {
                Ok(_) => break,
                Err(e) if up < 0.1 * reach => {
                    return Err(ImportError::new(
                        format!("axle {}", a.name),
                        "",
                        format!("{e}; correct the points of its arm"),
                    ));
                }
                Err(_) => up *= 0.85,
            }
        }
        a.suspension.stops = Some(Stops {
            jounce: 0.85 * up,
            rebound: -0.6 * up,
            stiffness: 5.0 * load / 0.1,
            table: Vec::new(),
        });
    }
    notes.assumed("stops of the road wheels' arms, which Chrono's have none of");
    Ok(())
}

/// The right track must have the wheels of the left one: their places are averaged.
fn same(set: &Set, right: &Node, wheels: &mut [Wheel], notes: &mut Notes) -> Result<(), ImportError> {
    for (key, name) in [("Sprocket", "sprocket"), ("Idler", "idler")] {
        if let (Some(n), Some(w)) = (right.get(key), wheels.iter_mut().find(|w| w.name == name)) {
            let doc = set.follow(&n.need("Input File")?, &[key])?;
            average(w, add(n.pt("Location")?, hub(&doc, "Carrier")?), notes);
        }
    }
    if let Some(list) = right.get("Suspension Subsystems") {
        for (i, n) in list.items()?.iter().enumerate() {
            let doc = set.follow(&n.need("Input File")?, SUSPENSION)?;
            n.get("Has Shock").inspect(Node::used);
            n.get("Lock Arm").inspect(Node::used);
            if let Some(w) = wheels.iter_mut().find(|w| w.name == format!("road{}", i + 1)) {
                average(w, add(n.pt("Location")?, hub(&doc, "Suspension Arm")?), notes);
            }
        }
    }
    notes.approximated(format!(
        "{}: but for places, the right track is the mirror image of the left one",
        right.doc().file
    ));
    Ok(())
}

/// The wheel's place on the part that carries it.
fn hub(doc: &Doc, part: &str) -> Result<Point, ImportError> {
    let place = doc.root().get(part).and_then(|p| p.get("Location Wheel"));
    place.map_or(Ok([0.0; 3]), |p| p.point())
}

fn average(w: &mut Wheel, right: Point, notes: &mut Notes) {
    if (w.at[0] - right[0]).abs() > 1e-6 || (w.at[2] - right[2]).abs() > 1e-6 {
        notes.approximated(format!(
            "{}: it stands {:.0} mm ahead of the right one; both stand in the middle",
            w.name,
            1000.0 * (w.at[0] - right[0])
        ));
        w.at[0] = 0.5 * (w.at[0] + right[0]);
        w.at[2] = 0.5 * (w.at[2] + right[2]);
    }
}

/// Wheels, belt and tensioner (stiffness, damping) of an assembly.
fn assembly(
    set: &Set,
    root: &Node,
    offset: f64,
    sprung: &mut Mass,
    notes: &mut Notes,
) -> Result<(Vec<Wheel>, Belt, [f64; 2]), ImportError> {
    let shoes = root.need("Track Shoes")?;
    let shoe = set.follow(&shoes.need("Input File")?, &["TrackShoe"])?;
    let belt = belt(&shoe.root(), shoes.num("Number Shoes")?)?;
    let brake = match root.get("Brake") {
        Some(n) => set.follow(&n.need("Input File")?, &["TrackBrake"])?.root().num("Maximum Torque")?,
        None => 0.0,
    };
    let mut wheels = Vec::new();
    let n = root.need("Sprocket")?;
    let gear = set.follow(&n.need("Input File")?, &["Sprocket"])?;
    let g = gear.root();
    let profile = g.need("Profile")?;
    wheels.push(Wheel {
        name: "sprocket".to_owned(),
        at: n.pt("Location")?,
        radius: profile.num("Assembly Radius")? + 0.5 * belt.thickness,
        mass: g.num("Gear Mass")?,
        spin: g.pt("Gear Inertia")?[1] + g.num_or("Axle Inertia", 0.0)?,
        arm: None,
        brake,
    });
    let n = root.need("Idler")?;
    let idler = set.follow(&n.need("Input File")?, &["Idler"])?;
    let carrier = idler.root().need("Carrier")?;
    let (radius, mass, spin) = match idler.root().get("Wheel") {
        // The wheel stood in the idler's file in Chrono 6 and before.
        Some(w) => disc(&w)?,
        None => wheel_of(set, &idler.root().need("Idler Wheel Input File")?)?,
    };
    let tensioner = match idler.root().get("Tensioner") {
        Some(t) => [t.num_or("Spring Coefficient", 1e6)?, t.num_or("Damping Coefficient", 1.4e4)?],
        None => [1e6, 1.4e4],
    };
    notes.approximated(format!(
        "{}: idlers are fixed; a quarter of the tensioner's stiffness and damping is the belt's",
        idler.file
    ));
    wheels.push(Wheel {
        name: "idler".to_owned(),
        at: add(n.pt("Location")?, hub(&idler, "Carrier")?),
        radius: radius + belt.thickness,
        mass: mass + carrier.num_or("Mass", 0.0)?,
        spin,
        arm: None,
        brake: 0.0,
    });
    let list = root.need("Suspension Subsystems")?;
    let entries = list.items()?;
    if entries.len() < 2 {
        return list.fail(format!("{} road wheels; at least two are expected", entries.len()));
    }
    for (i, n) in entries.iter().enumerate() {
        let doc = set.follow(&n.need("Input File")?, SUSPENSION)?;
        let shock = n.get("Has Shock").map_or(Ok(true), |f| f.flag())?;
        wheels.push(road(set, &doc, n.pt("Location")?, i, shock, offset, &belt, sprung, notes)?);
    }
    if let Some(list) = root.get("Rollers") {
        for n in list.items()? {
            let (_, mass, _) = wheel_of(set, &n.need("Input File")?)?;
            let at = n.pt("Location")?;
            for side in [offset, -offset] {
                *sprung = sprung.plus(&Mass::point(mass, [at[0], side, at[2]]));
            }
        }
        notes.dropped(format!("{}: return rollers; their masses are the chassis's", list.at()));
    }
    Ok((wheels, belt, tensioner))
}

/// Radius, mass and spin inertia of a wheel's file.
fn wheel_of(set: &Set, from: &Node) -> Result<(f64, f64, f64), ImportError> {
    let doc = set.follow(from, &["TrackWheel", "IdlerWheel", "RoadWheel", "Roller"])?;
    let root = doc.root();
    disc(&root.get("Roller").map_or_else(|| root.need("Wheel"), Ok)?)
}

fn disc(w: &Node) -> Result<(f64, f64, f64), ImportError> {
    Ok((w.num("Radius")?, w.num("Mass")?, w.pt("Inertia")?[1]))
}

#[allow(clippy::too_many_arguments, reason = "one wheel of one assembly")]
fn road(
    set: &Set,
    doc: &Doc,
    at: Point,
    index: usize,
    shock: bool,
    offset: f64,
    belt: &Belt,
    sprung: &mut Mass,
    notes: &mut Notes,
) -> Result<Wheel, ImportError> {
    let root = doc.root();
    let (radius, mut mass, spin) = wheel_of(set, &root.need("Road Wheel Input File")?)?;
    let arm = root.need("Suspension Arm")?;
    let wheel = hub(doc, "Suspension Arm")?;
    let place = |p: Point| [p[0] - wheel[0], p[1] + offset, p[2] - wheel[2]];
    let pivot = place(arm.pt("Location Chassis")?);
    let half = 0.5 * arm.num("Mass")?;
    mass += half;
    for p in [pivot, mirrored(pivot)] {
        *sprung = sprung.plus(&Mass::point(half, add(at, p)));
    }
    let spring = root.need("Torsional Spring")?;
    let free = spring.num_or("Free Angle", 0.0)?;
    let mut preload = spring.num_or("Preload", 0.0)?;
    let stiffness = match spring.any(&["Spring Constant", "Spring Coefficient"]) {
        Some(n) => {
            let stiffness = n.number()?;
            preload += stiffness * free;
            stiffness
        }
        None => {
            let n = spring.need("Spring Curve Data")?;
            let (torque, slope) = vb_vehicle::table::interpolate(&n.table()?, -free);
            notes.approximated(format!(
                "{}: the torsion bar is linear with the slope at the design position",
                n.at()
            ));
            preload -= torque;
            slope
        }
    };
    let mut damping = spring.num_or("Damping Coefficient", 0.0)?;
    if let Some(n) = spring.get("Damping Curve Data") {
        damping += steepest(&n, notes)?;
    }
    // Torque that pushes the wheel down at the design position.
    let preload = preload.abs();
    let mut struts = Vec::new();
    if let Some(d) = root.get("Damper") {
        if !shock {
            d.used();
        } else if d.has("Location Chassis") {
            let (chassis, end) = (place(d.pt("Location Chassis")?), place(d.pt("Location Arm")?));
            let damper = match d.get("Damping Coefficient") {
                Some(c) => Damper::Linear { coefficient: c.number()? },
                None => {
                    let n = curve(&d)?;
                    Damper::Table { points: rates(turned(n.table()?), &n.at(), notes) }
                }
            };
            struts.push(Strut {
                chassis,
                end,
                part: Part::Arm,
                spring: None,
                damper: Some(damper),
                stops: None,
            });
        } else {
            damping += match d.get("Damping Coefficient") {
                Some(c) => c.number()?,
                None => steepest(&curve(&d)?, notes)?,
            };
        }
    }
    if let Some(n) = arm.get("COM") {
        n.used();
    }
    let linkage = TorsionArm {
        spindle: [0.0, offset, 0.0],
        pivot,
        axis: [0.0, 1.0, 0.0],
        torsion: Some(Torsion { stiffness, damping, preload }),
    };
    let centre = [at[0] + wheel[0], 0.0, at[2] + wheel[2]];
    Ok(Wheel {
        name: format!("road{}", index + 1),
        at: centre,
        radius: radius + belt.thickness,
        mass,
        spin,
        arm: Some(Suspension {
            linkage: Linkage::TorsionArm(linkage),
            range: [0.0; 2],
            struts,
            stops: None,
            anti_roll: None,
        }),
        brake: 0.0,
    })
}

/// The curve of a damper, under its name of today and that of Chrono 6.
fn curve<'a>(damper: &Node<'a>) -> Result<Node<'a>, ImportError> {
    damper.get("Curve Data").map_or_else(|| damper.need("Damping Curve Data"), Ok)
}

/// The steepest slope of a rotary damper's curve, N m s/rad.
fn steepest(n: &Node, notes: &mut Notes) -> Result<f64, ImportError> {
    notes.approximated(format!(
        "{}: the rotary damper is linear with the steepest slope of its curve",
        n.at()
    ));
    let forward = n.table()?.into_iter().filter(|p| p[0] > 0.0);
    Ok(forward.map(|p| p[1] / p[0]).fold(0.0, f64::max))
}

/// The belt of this number of shoes.
fn belt(root: &Node, count: f64) -> Result<Belt, ImportError> {
    let (mut thickness, mut width, mut friction, mut mass) = (0.0, 0.0, None, 0.0);
    for key in ["Shoe", "Tread", "Web", "Connector"] {
        if let Some(n) = root.get(key) {
            // Two connectors hold a double-pin shoe.
            let each = if key == "Connector" { 2.0 } else { 1.0 };
            mass += each * n.num_or("Mass", 0.0)?;
            thickness = n.num_or("Height", thickness)?;
        }
    }
    if let Some(n) = root.get("Shoe Mass") {
        mass += n.number()?;
    }
    thickness = root.num_or("Shoe Height", thickness)?;
    if let Some(n) = root.get("Shoe").and_then(|s| s.get("Width")) {
        width = n.number()?;
    }
    width = root.num_or("Belt Width", width)?;
    if let Some(contact) = root.get("Contact") {
        if let Some(list) = contact.get("Shoe Materials")
            && let Some(first) = list.items()?.first()
        {
            friction = Some(first.num("Coefficient of Friction")?);
        }
        if let Some(list) = contact.get("Shoe Shapes") {
            for s in list.items()? {
                if s.has("Dimensions") && s.get("Ground Contact").is_some_and(|n| n.flag().unwrap_or(false)) {
                    let (at, size) = (s.pt("Location")?, s.pt("Dimensions")?);
                    width = f64::max(width, 2.0 * (at[1].abs() + 0.5 * size[1]));
                }
            }
        }
    }
    if let Some(n) = root.get("Contact Materials").and_then(|m| m.get("Pad Material")) {
        friction = Some(n.num("Coefficient of Friction")?);
    }
    let belt = Belt { thickness, width, friction: friction.unwrap_or(0.8), mass: mass * count };
    if belt.mass <= 0.0 || thickness <= 0.0 || width <= 0.0 {
        return root.fail(format!(
            "a belt of {} kg, {thickness} m thick and {width} m wide; mass, \"Height\" and width of its shoes must be positive",
            belt.mass
        ));
    }
    Ok(belt)
}

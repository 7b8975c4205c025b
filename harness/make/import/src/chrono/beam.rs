//! Suspensions with a beam between the wheels.

use super::json::Node;
use super::parts::{Parts, ball, half, parts, spindle};
use super::strut::struts;
use crate::place::{add, length, middle, mirrored, scale, sub};
use crate::{ImportError, Notes};
use vb_vehicle::Point;
use vb_vehicle::suspension::{
    AntiRoll, Beam, KnuckleDrive, Knuckles, LeafAxle, Linkage, Part, PivotAxle, Rod, SolidAxle, Spring, Strut,
};

/// Length of the rods and leaves that stand for a guide in a plane, m.
const GUIDE: f64 = 1.5;

pub(super) fn read(root: &Node, template: &str, notes: &mut Notes) -> Result<Parts, ImportError> {
    let (centre, spindle_mass, spin) = spindle(root)?;
    let tube = root.need(if template == "RigidPinnedAxle" { "Tube" } else { "Axle Tube" })?;
    let mut beam = Beam { mass: tube.num("Mass")?, inertia: tube.pt("Inertia")?[2] };
    if let Some(com) = tube.get("COM") {
        let com = com.point()?;
        if length(sub(com, [centre[0], 0.0, centre[2]])) > 0.05 {
            notes.approximated(format!(
                "{}: the beam's centre of mass lies between the wheels, not at {com:?}",
                tube.at()
            ));
        }
    }
    let mut unsprung = spindle_mass;
    let steered = root.has("Knuckle");
    if let Some(k) = root.get("Knuckle") {
        unsprung += k.num("Mass")?;
        k.get("COM").inspect(Node::used);
    }
    let knuckles = if steered { Some(knuckles(root, template, &mut beam, notes)?) } else { None };
    let mut out = parts(
        Linkage::Rigid(vb_vehicle::suspension::RigidMount { spindle: centre }),
        Vec::new(),
        unsprung,
        spin,
        None,
    );
    out.mirrored = match root.get("Knuckle").and_then(|k| k.get("Location Draglink")) {
        Some(n) => n.point()?[1] < 0.0,
        None => false,
    };
    let mut struts = struts(root, &["Spring", "Auxiliary Spring", "Shock"], Part::Beam, notes)?;
    let (links, single) = match template {
        "RigidPinnedAxle" => {
            let pin = tube.pt("Pin Location")?;
            clamp(&mut beam, centre, root, notes);
            out.linkage =
                Linkage::PivotAxle(PivotAxle { spindle: centre, beam, pin_height: pin[2], knuckles });
            return Ok(out);
        }
        "LeafspringAxle" | "ToeBarLeafspringAxle" => {
            let Some(spring) = struts.iter().find(|s| s.spring.is_some()) else {
                return root.fail("no spring carries the axle");
            };
            let seat = [spring.end[0], spring.end[1], spring.end[2]];
            clamp(&mut beam, centre, root, notes);
            notes.approximated(format!(
                "{}: Chrono guides this axle in its plane; here leaf springs of {GUIDE} m to the fixed eye guide it",
                root.doc().file
            ));
            out.linkage = Linkage::LeafAxle(LeafAxle {
                spindle: centre,
                beam,
                seat,
                eye: add(seat, [GUIDE, 0.0, 0.0]),
                knuckles,
            });
            out.struts = struts;
            return Ok(out);
        }
        "SAELeafspringAxle" | "SAEToeBarLeafspringAxle" => {
            let leaf = leaf(root, &mut struts, &mut beam, &mut out, notes)?;
            clamp(&mut beam, centre, root, notes);
            out.linkage =
                Linkage::LeafAxle(LeafAxle { spindle: centre, beam, seat: leaf.0, eye: leaf.1, knuckles });
            out.struts = struts;
            return Ok(out);
        }
        "SolidAxle" => {
            let rods = ["Upper Link", "Lower Link"].map(|k| link(root, k, &mut out, &mut beam));
            let [upper, lower] = rods;
            (vec![upper?, lower?], Vec::new())
        }
        "SolidThreeLinkAxle" | "SolidBellcrankThreeLinkAxle" => {
            let mut triangle = link(root, "Triangular Link", &mut out, &mut beam)?;
            // Its tip is one ball joint in the middle.
            triangle.carrier[1] = 0.0;
            (vec![triangle, link(root, "Longitudinal Link", &mut out, &mut beam)?], Vec::new())
        }
        "PushPipeAxle" | "ToeBarPushPipeAxle" => {
            let joint = tube.pt("Location Connector Chassis")?;
            let mut rods = ball(joint, [1.0, 1.0, 1.0]).to_vec();
            rods.push(panhard(root, &mut out, &mut beam)?);
            notes.approximated(format!(
                "{}: the ball joint of the push pipe is three rods that meet in its centre (exact)",
                root.doc().file
            ));
            (Vec::new(), rods)
        }
        "DeDionAxle" | "ToeBarDeDionAxle" => {
            let key = "Location Connector";
            let joint = tube.get("Location Connector Chassis").map_or_else(|| tube.pt(key), |n| n.point())?;
            let mut rods = ball(joint, [1.0, 1.0, 1.0]).to_vec();
            let at = [centre[0], 0.0, centre[2]];
            watt(root, centre, &mut out, &mut beam)?;
            rods.push(Rod { chassis: add(at, [0.0, GUIDE, 0.0]), carrier: at });
            notes.approximated(format!(
                "{}: the De Dion tube turns about its connector; a rod of {GUIDE} m across the axle guides it sideways in place of a Watt linkage",
                root.doc().file
            ));
            (Vec::new(), rods)
        }
        _ => {
            let rod = panhard(root, &mut out, &mut beam)?;
            let behind = |p: Point| Rod { chassis: add(p, [-GUIDE, 0.0, 0.0]), carrier: p };
            let [x, y, z] = centre;
            notes.approximated(format!(
                "{}: Chrono guides this axle in its plane; here three rods of {GUIDE} m along the vehicle do",
                root.doc().file
            ));
            bar(root, centre, &mut out, &mut beam, notes)?;
            (vec![behind([x, 0.6 * y, z - 0.1])], vec![behind([x, 0.0, z + 0.2]), rod])
        }
    };
    clamp(&mut beam, centre, root, notes);
    out.linkage =
        Linkage::SolidAxle(SolidAxle { spindle: centre, beam, links, single_links: single, knuckles });
    out.struts = struts;
    Ok(out)
}

/// A beam's inertia cannot exceed that of its mass at the wheels.
fn clamp(beam: &mut Beam, spindle: Point, root: &Node, notes: &mut Notes) {
    let most = 0.5 * beam.mass * spindle[1] * spindle[1];
    if beam.inertia > most {
        notes.approximated(format!(
            "{}: the tube's moment of inertia of {} kg m² is more than a tube of its mass and length can have; {most:.3} is used",
            root.doc().file,
            beam.inertia
        ));
        beam.inertia = most;
    }
}

/// A link between chassis and beam, at both sides.
fn link(root: &Node, key: &str, out: &mut Parts, beam: &mut Beam) -> Result<Rod, ImportError> {
    let node = root.need(key)?;
    let rod = Rod { chassis: node.pt("Location Chassis")?, carrier: node.pt("Location Axle")? };
    let before = out.unsprung;
    half(&node, &[rod.chassis], out)?;
    // A triangle exists once, other links at both sides; either half moves with the beam.
    if key == "Triangular Link" {
        beam.mass += out.unsprung - before;
        let kept = out.sprung.len().saturating_sub(2);
        if out.unsprung > before {
            let (mass, at) = out.sprung[kept];
            out.sprung.truncate(kept);
            out.sprung.push((mass, [at[0], 0.0, at[2]]));
        }
    } else {
        beam.mass += 2.0 * (out.unsprung - before);
    }
    out.unsprung = before;
    Ok(rod)
}

/// A Panhard rod, which exists once.
fn panhard(root: &Node, out: &mut Parts, beam: &mut Beam) -> Result<Rod, ImportError> {
    let node = root.need("Panhard Rod")?;
    let end = |keys: &[&str]| match node.any(keys) {
        Some(n) => n.point(),
        None => node.fail(format!("{} is missing", keys[0])),
    };
    let rod = Rod {
        chassis: end(&["Location Chassis", "Location Connector Chassis"])?,
        carrier: end(&["Location Axle", "Location Connector Axle"])?,
    };
    let mass = node.num_or("Mass", 0.0)?;
    beam.mass += 0.5 * mass;
    out.sprung.push((0.5 * mass, rod.chassis));
    Ok(rod)
}

/// The masses of a Watt linkage: its centre link and half of its side links move with the beam.
fn watt(root: &Node, spindle: Point, out: &mut Parts, beam: &mut Beam) -> Result<(), ImportError> {
    let Some(node) = root.get("Watt Mechanism") else { return Ok(()) };
    let side = node.num_or("Side Link Mass", 0.0)?;
    beam.mass += node.num_or("Center Link Mass", 0.0)? + side;
    for key in ["Location Left Link to Chassis", "Location Right Link to Chassis"] {
        let end = node.get(key).map_or(Ok(spindle), |n| n.point())?;
        out.sprung.push((0.5 * side, end));
    }
    Ok(())
}

/// The anti-roll bar of a beam: its twist over the difference of the wheels' travels.
fn bar(
    root: &Node,
    spindle: Point,
    out: &mut Parts,
    beam: &mut Beam,
    notes: &mut Notes,
) -> Result<(), ImportError> {
    let Some(node) = root.get("Anti Roll Bar") else { return Ok(()) };
    let (on, chassis) = (node.pt("Location Axle")?, node.pt("Location Chassis")?);
    let arm = (on[0] - chassis[0]).abs();
    let stiffness = node.num("Rotational Stiffness")?;
    beam.mass += node.num_or("Mass", 0.0)?;
    if arm < 0.01 || stiffness <= 0.0 {
        notes.dropped(format!(
            "{}: a bar with arms of {arm:.3} m and {stiffness} N m/rad does not act",
            node.at()
        ));
        return Ok(());
    }
    let ratio = on[1].abs() / spindle[1];
    out.anti_roll = Some(AntiRoll::Travel { stiffness: stiffness * (ratio / arm) * (ratio / arm) });
    notes.approximated(format!(
        "{}: the bar is its stiffness over the difference of the wheels' travels, without damping",
        node.at()
    ));
    Ok(())
}

/// The leaf springs of an SAE three-link model: seat and fixed eye. Their stiffness becomes a vertical spring at the seat.
fn leaf(
    root: &Node,
    struts: &mut Vec<Strut>,
    beam: &mut Beam,
    out: &mut Parts,
    notes: &mut Notes,
) -> Result<(Point, Point), ImportError> {
    /// Length of this spring, m.
    const TALL: f64 = 0.3;
    let node = root.need("Leafspring")?;
    let eye = node.pt("Location Front Hanger")?;
    let seat = middle(&[node.pt("Location Clamp A")?, node.pt("Location Clamp B")?]);
    for key in ["Location Shackle", "Location Rear Hanger"] {
        node.get(key).inspect(Node::used);
    }
    let stiffness = node.num("Vertical Stiffness")?;
    let preload = node.num_or("Vertical Preload Force", 0.0)?;
    for key in ["Frontleaf", "Rearleaf"] {
        if let Some(l) = node.get(key) {
            let mass = l.num_or("Mass", 0.0)?;
            beam.mass += mass;
            out.sprung.push((0.5 * mass, eye));
            out.sprung.push((0.5 * mass, mirrored(eye)));
        }
    }
    for (key, count) in [("Half Clamp", 4.0), ("Shackle", 0.0)] {
        if let Some(l) = node.get(key) {
            beam.mass += count * l.num_or("Mass", 0.0)?;
        }
    }
    let spring =
        Spring::Linear { stiffness, free_length: TALL + preload / stiffness.max(1e-9), preload: 0.0 };
    let mut leaf = Strut {
        chassis: add(seat, [0.0, 0.0, TALL]),
        end: seat,
        part: Part::Beam,
        spring: Some(spring),
        damper: None,
        stops: None,
    };
    // A wheel has two struts at most: an auxiliary spring joins the leaf.
    if let Some(k) = struts.iter().position(|s| s.spring.is_some()) {
        let auxiliary = struts.remove(k);
        let design = length(sub(auxiliary.chassis, auxiliary.end));
        if let (Some(own), Some(Spring::Linear { stiffness, free_length, .. })) =
            (&auxiliary.spring, &mut leaf.spring)
        {
            let step = 0.01;
            let (force, rate) = (own.force(design), (own.force(design - step) - own.force(design)) / step);
            let total = preload + force;
            *stiffness += rate;
            *free_length = TALL + total / *stiffness;
        }
        notes.approximated(format!(
            "{}: auxiliary spring and leaf spring are one linear spring at the leaf's seat",
            root.doc().file
        ));
    }
    struts.insert(0, leaf);
    notes.approximated(format!(
        "{}: the leaf spring is a link of three quarters of its fixed half (SAE HS-788) with the vertical stiffness as a spring at its seat",
        node.at()
    ));
    Ok((seat, eye))
}

fn knuckles(
    root: &Node,
    template: &str,
    beam: &mut Beam,
    notes: &mut Notes,
) -> Result<Knuckles, ImportError> {
    let k = root.need("Knuckle")?;
    let lower = k.pt("Location Lower")?;
    let upper = k.pt("Location Upper")?;
    let tie = root.get("Tierod");
    if let Some(t) = &tie {
        beam.mass += t.num_or("Mass", 0.0)?;
    }
    let knuckle = match (k.get("Location Tierod"), &tie) {
        (Some(n), _) => n.point()?,
        (None, Some(t)) => t.pt("Location Knuckle")?,
        (None, None) => return root.fail("\"Tierod\" is missing; the template needs it"),
    };
    let drag = root.need("Draglink")?;
    beam.mass += 0.5 * drag.num_or("Mass", 0.0)?;
    let end = |node: &Node, keys: &[&str]| match node.any(keys) {
        Some(n) => n.point(),
        None => node.fail(format!("{} is missing", keys[0])),
    };
    let inner = end(&drag, &["Location Chassis", "Location Steering"])?;
    if let Some(crank) = root.any(&["Bellcrank", "Bell Crank"]) {
        beam.mass += crank.num_or("Mass", 0.0)?;
        let (rod, pivot) = (crank.pt("Location Tierod")?, crank.pt("Location Axle")?);
        let outer = end(&drag, &["Location Bellcrank", "Location Bell Crank"])?;
        if template == "SolidAxle" {
            // The crank shifts the tie rod across the axle: the left knuckle turns as if the drag link pulled it by a lever parallel
            // to the crank's, longer by the ratio of the knuckle's arm to the crank's.
            let (arm, own) = (knuckle[0] - middle(&[lower, upper])[0], rod[0] - pivot[0]);
            if own * arm <= 0.0 {
                return crank.fail(format!(
                    "its arm to the tie rod is {own} m long along the vehicle and the knuckle's {arm} m; both must point the same way"
                ));
            }
            let lever = scale(sub(outer, pivot), arm / own);
            let outer_here = add([lower[0], middle(&[lower, upper])[1], outer[2]], [lever[0], lever[1], 0.0]);
            notes.approximated(format!(
                "{}: the drag link pulls the left knuckle by a lever parallel to the bell crank's",
                root.doc().file
            ));
            return Ok(Knuckles {
                kingpin_lower: lower,
                kingpin_upper: upper,
                tie_rod: knuckle,
                drag_link_inner: add(outer_here, sub(inner, outer)),
                by: KnuckleDrive::Toebar { drag_link_outer: outer_here },
            });
        }
        return Ok(Knuckles {
            kingpin_lower: lower,
            kingpin_upper: upper,
            tie_rod: knuckle,
            drag_link_inner: inner,
            by: KnuckleDrive::Bellcrank {
                pivot,
                axis: [0.0, 0.0, 1.0],
                drag_link_outer: outer,
                tie_rod_left: rod,
                tie_rod_right: mirrored(rod),
            },
        });
    }
    let mut outer = k.pt("Location Draglink")?;
    let mut inner = inner;
    if outer[1] < 0.0 {
        // The simulator's drag link turns the left knuckle; a toe bar carries its motion over.
        outer = mirrored(outer);
        inner = mirrored(inner);
        notes.approximated(format!(
            "{}: the drag link is mirrored, since it turns the left knuckle here and the right one there",
            root.doc().file
        ));
    }
    Ok(Knuckles {
        kingpin_lower: lower,
        kingpin_upper: upper,
        tie_rod: knuckle,
        drag_link_inner: inner,
        by: KnuckleDrive::Toebar { drag_link_outer: outer },
    })
}

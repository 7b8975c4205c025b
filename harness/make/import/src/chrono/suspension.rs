//! Suspensions with wheels that are guided independently, and the choice among the templates.

use super::json::Node;
use super::parts::{Parts, ball, half, parts, spindle};
use super::strut::{levered, struts};
use crate::place::{add, dot, length, middle, scale, sub};
use crate::{ImportError, Notes};
use vb_vehicle::Point;
use vb_vehicle::suspension::{
    DoubleWishbone, Linkage, Multilink, Part, RigidMount, Rod, SingleWishbone, TorsionArm,
};

/// The templates that have a counterpart.
pub(crate) const TEMPLATES: &[&str] = &[
    "DoubleWishbone",
    "DoubleWishboneReduced",
    "SingleWishbone",
    "MultiLink",
    "ThreeLinkIRS",
    "SemiTrailingArm",
    "MacPhersonStrut",
    "RigidSuspension",
    "RigidPinnedAxle",
    "SolidAxle",
    "SolidThreeLinkAxle",
    "SolidBellcrankThreeLinkAxle",
    "LeafspringAxle",
    "ToeBarLeafspringAxle",
    "SAELeafspringAxle",
    "SAEToeBarLeafspringAxle",
    "PushPipeAxle",
    "ToeBarPushPipeAxle",
    "DeDionAxle",
    "ToeBarDeDionAxle",
    "RigidPanhardAxle",
    "ToeBarRigidPanhardAxle",
];

/// Reads a suspension of any template.
pub(crate) fn read(root: &Node, notes: &mut Notes) -> Result<Parts, ImportError> {
    let template = super::set::template(root.doc())?;
    alignment(root, notes)?;
    match template.as_str() {
        "DoubleWishbone" | "DoubleWishboneReduced" => double_wishbone(root, notes),
        "SingleWishbone" => single_wishbone(root, notes),
        "MultiLink" => multilink(root, notes),
        "ThreeLinkIRS" => trailing_arm(root, notes),
        "SemiTrailingArm" => semi_trailing_arm(root, notes),
        "MacPhersonStrut" => mcpherson(root, notes),
        "RigidSuspension" => rigid(root),
        t if TEMPLATES.contains(&t) => super::beam::read(root, t, notes),
        other => root.fail(format!(
            "no counterpart of the template {other:?}; use one of {} for this axle",
            TEMPLATES.join(", ")
        )),
    }
}

/// Camber and toe, which wheels of the simulator have only by their linkages.
fn alignment(root: &Node, notes: &mut Notes) -> Result<(), ImportError> {
    for key in ["Camber Angle (deg)", "Toe Angle (deg)"] {
        if let Some(n) = root.get(key)
            && n.number()? != 0.0
        {
            notes.dropped(format!(
                "{}: {}; wheels stand upright and straight at the design height",
                n.at(),
                n.number()?
            ));
        }
    }
    // The axes of bodies whose inertias the simulator's massless links don't have.
    if let Some(n) = root.get("Vehicle-Frame Inertia") {
        n.used();
    }
    Ok(())
}

fn double_wishbone(root: &Node, notes: &mut Notes) -> Result<Parts, ImportError> {
    let (centre, spindle_mass, spin) = spindle(root)?;
    let (upper, lower) = (root.need("Upper Control Arm")?, root.need("Lower Control Arm")?);
    let tie = root.need("Tierod")?;
    let arm = |n: &Node| -> Result<[Point; 3], ImportError> {
        Ok([n.pt("Location Chassis Front")?, n.pt("Location Chassis Back")?, n.pt("Location Upright")?])
    };
    let ([uf, ub, uu], [lf, lb, lu]) = (arm(&upper)?, arm(&lower)?);
    let linkage = DoubleWishbone {
        spindle: centre,
        upper_arm_front: uf,
        upper_arm_rear: ub,
        upper_ball_joint: uu,
        lower_arm_front: lf,
        lower_arm_rear: lb,
        lower_ball_joint: lu,
        tie_rod_inner: tie.pt("Location Chassis")?,
        tie_rod_outer: tie.pt("Location Upright")?,
    };
    let reduced = super::set::template(root.doc())? == "DoubleWishboneReduced";
    let on = if reduced { Part::Upright } else { Part::Arm };
    let struts = struts(root, &["Spring", "Shock"], on, notes)?;
    let mass = spindle_mass + root.need("Upright")?.num("Mass")?;
    let mut out = parts(Linkage::DoubleWishbone(linkage.clone()), struts, mass, spin, Some(on));
    half(&upper, &[uf, ub], &mut out)?;
    half(&lower, &[lf, lb], &mut out)?;
    half(&tie, &[linkage.tie_rod_inner], &mut out)?;
    bushings(&[&upper, &lower, &tie], notes);
    Ok(out)
}

/// Joints are ideal in the simulator.
fn bushings(links: &[&Node], notes: &mut Notes) {
    for n in links.iter().filter_map(|l| l.get("Bushing Data")) {
        n.used();
        notes.dropped(format!("{}: joints of linkages are ideal", n.at()));
    }
}

fn single_wishbone(root: &Node, notes: &mut Notes) -> Result<Parts, ImportError> {
    let (centre, spindle_mass, spin) = spindle(root)?;
    let (arm, tie) = (root.need("Control Arm")?, root.need("Tierod")?);
    let (chassis, upright) = (arm.pt("Location Chassis")?, arm.pt("Location Upright")?);
    let along = |x: f64| add(chassis, [x, 0.0, 0.0]);
    let linkage = SingleWishbone {
        spindle: centre,
        arm_front: along(0.1),
        arm_rear: along(-0.1),
        kingpin_lower: upright,
        kingpin_upper: add(upright, [0.0, 0.0, 0.1]),
        tie_rod_inner: tie.pt("Location Chassis")?,
        tie_rod_outer: tie.pt("Location Upright")?,
    };
    let struts = struts(root, &["Spring", "Shock"], Part::Arm, notes)?;
    let mass = spindle_mass + root.need("Upright")?.num("Mass")?;
    let mut out = parts(Linkage::SingleWishbone(linkage.clone()), struts, mass, spin, Some(Part::Arm));
    half(&arm, &[chassis], &mut out)?;
    half(&tie, &[linkage.tie_rod_inner], &mut out)?;
    bushings(&[&arm, &tie], notes);
    Ok(out)
}

fn multilink(root: &Node, notes: &mut Notes) -> Result<Parts, ImportError> {
    let (centre, spindle_mass, spin) = spindle(root)?;
    let (upper, lateral, trailing, tie) =
        (root.need("Upper Arm")?, root.need("Lateral")?, root.need("Trailing Link")?, root.need("Tierod")?);
    let tip = upper.pt("Location Upright")?;
    let (front, back) = (upper.pt("Location Chassis Front")?, upper.pt("Location Chassis Back")?);
    let rod = |n: &Node| -> Result<Rod, ImportError> {
        for key in ["Universal Joint Axis Link", "Universal Joint Axis Chassis"] {
            n.get(key).inspect(Node::used);
        }
        Ok(Rod { chassis: n.pt("Location Chassis")?, carrier: n.pt("Location Upright")? })
    };
    let (lateral_rod, trailing_rod) = (rod(&lateral)?, rod(&trailing)?);
    let linkage = Multilink {
        spindle: centre,
        links: [
            Rod { chassis: front, carrier: tip },
            Rod { chassis: back, carrier: tip },
            lateral_rod,
            trailing_rod,
        ],
        tie_rod_inner: tie.pt("Location Chassis")?,
        tie_rod_outer: tie.pt("Location Upright")?,
    };
    // Springs sit on the trailing link.
    let link = sub(trailing_rod.carrier, trailing_rod.chassis);
    let mut moved = Vec::new();
    for s in struts(root, &["Spring", "Shock"], Part::Upright, notes)? {
        let fraction = dot(sub(s.end, trailing_rod.chassis), link) / dot(link, link).max(1e-12);
        if !(0.05..=2.0).contains(&fraction) {
            return trailing
                .fail("a spring or shock sits at the link's end on the chassis, where it carries nothing");
        }
        moved.push(levered(&s, trailing_rod.carrier, fraction));
    }
    notes.approximated(format!(
        "{}: springs and shocks on the trailing link act at its outer end, with the same wheel rate at the design height",
        root.doc().file
    ));
    let mass = spindle_mass + root.need("Upright")?.num("Mass")?;
    let mut out = parts(Linkage::Multilink(linkage.clone()), moved, mass, spin, Some(Part::Upright));
    half(&upper, &[front, back], &mut out)?;
    half(&lateral, &[lateral_rod.chassis], &mut out)?;
    half(&trailing, &[trailing_rod.chassis], &mut out)?;
    half(&tie, &[linkage.tie_rod_inner], &mut out)?;
    bushings(&[&upper, &lateral, &trailing, &tie], notes);
    Ok(out)
}

/// A trailing arm on a ball joint with two lateral links: the ball joint is three rods that meet in its centre.
fn trailing_arm(root: &Node, notes: &mut Notes) -> Result<Parts, ImportError> {
    let (centre, spindle_mass, spin) = spindle(root)?;
    let (arm, upper, lower) =
        (root.need("Trailing Arm")?, root.need("Upper Link")?, root.need("Lower Link")?);
    let pivot = arm.pt("Location Chassis")?;
    arm.get("Location Spindle").inspect(Node::used);
    let rod = |n: &Node| -> Result<Rod, ImportError> {
        n.get("Universal Joint Axis").inspect(Node::used);
        Ok(Rod { chassis: n.pt("Location Chassis")?, carrier: n.pt("Location Arm")? })
    };
    let (u, l) = (rod(&upper)?, rod(&lower)?);
    let [a, b, c] = ball(pivot, [1.0, -1.0, 1.0]);
    let linkage = Multilink {
        spindle: centre,
        links: [a, b, c, u],
        tie_rod_inner: l.chassis,
        tie_rod_outer: l.carrier,
    };
    notes.approximated(format!(
        "{}: the arm's ball joint is three rods that meet in its centre (exact)",
        root.doc().file
    ));
    let struts = struts(root, &["Spring", "Shock"], Part::Upright, notes)?;
    let mut out = parts(Linkage::Multilink(linkage), struts, spindle_mass, spin, Some(Part::Upright));
    half(&arm, &[pivot], &mut out)?;
    half(&upper, &[u.chassis], &mut out)?;
    half(&lower, &[l.chassis], &mut out)?;
    bushings(&[&arm, &upper, &lower], notes);
    Ok(out)
}

fn semi_trailing_arm(root: &Node, notes: &mut Notes) -> Result<Parts, ImportError> {
    let (centre, spindle_mass, spin) = spindle(root)?;
    let arm = root.need("Trailing Arm")?;
    let (outer, inner) = (arm.pt("Location Chassis Outer")?, arm.pt("Location Chassis Inner")?);
    arm.get("Location Spindle").inspect(Node::used);
    let axis = sub(outer, inner);
    if length(axis) < 1e-6 {
        return arm.fail("Location Chassis Outer and Inner are one point, which gives no axis");
    }
    let linkage = TorsionArm {
        spindle: centre,
        pivot: middle(&[outer, inner]),
        axis: scale(axis, 1.0 / length(axis)),
        torsion: None,
    };
    let struts = struts(root, &["Spring", "Shock"], Part::Arm, notes)?;
    let mut out = parts(Linkage::TorsionArm(linkage), struts, spindle_mass, spin, Some(Part::Arm));
    half(&arm, &[outer, inner], &mut out)?;
    bushings(&[&arm], notes);
    Ok(out)
}

/// A McPherson strut: its slide is two long rods across its axis at the top mount.
fn mcpherson(root: &Node, notes: &mut Notes) -> Result<Parts, ImportError> {
    /// Length of these rods, m.
    const SLIDE: f64 = 2.0;
    let (centre, spindle_mass, spin) = spindle(root)?;
    let (arm, tie) = (root.need("Control Arm")?, root.need("Tierod")?);
    let (front, back, tip) =
        (arm.pt("Location Chassis Front")?, arm.pt("Location Chassis Back")?, arm.pt("Location Upright")?);
    let spring = root.need("Spring")?;
    let (top, foot) = (spring.pt("Location Chassis")?, spring.pt("Location Upright")?);
    let along = sub(top, foot);
    if length(along) < 1e-6 {
        return spring.fail("both ends are one point, which gives the strut no axis");
    }
    let along = scale(along, 1.0 / length(along));
    // Two directions across the strut: inwards, and backwards.
    let across = |d: Point| {
        let d = sub(d, scale(along, dot(d, along)));
        scale(d, 1.0 / length(d).max(1e-9))
    };
    let rod = |d: Point| Rod { chassis: add(top, scale(across(d), SLIDE)), carrier: top };
    let linkage = Multilink {
        spindle: centre,
        links: [
            Rod { chassis: front, carrier: tip },
            Rod { chassis: back, carrier: tip },
            rod([0.0, -1.0, 0.0]),
            rod([-1.0, 0.0, 0.0]),
        ],
        tie_rod_inner: tie.pt("Location Chassis")?,
        tie_rod_outer: tie.pt("Location Upright")?,
    };
    notes.approximated(format!(
        "{}: the slide of the McPherson strut is two rods of {SLIDE} m across its axis at the top mount",
        root.doc().file
    ));
    let mut struts = struts(root, &["Spring", "Shock"], Part::Upright, notes)?;
    // The top mount of the upright's rods is not the strut's foot: struts that meet in the mount need a length.
    struts.retain(|s| length(sub(s.chassis, s.end)) > 1e-6);
    let mut mass = spindle_mass + root.need("Upright")?.num("Mass")?;
    let strut = root.get("Strut").map_or(Ok(0.0), |s| s.num_or("Mass", 0.0))?;
    mass += 0.5 * strut;
    let mut out = parts(Linkage::Multilink(linkage.clone()), struts, mass, spin, Some(Part::Upright));
    for side in [1.0, -1.0] {
        out.sprung.push((0.5 * strut, [top[0], side * top[1], top[2]]));
    }
    half(&arm, &[front, back], &mut out)?;
    half(&tie, &[linkage.tie_rod_inner], &mut out)?;
    bushings(&[&arm, &tie], notes);
    Ok(out)
}

fn rigid(root: &Node) -> Result<Parts, ImportError> {
    let (centre, mass, spin) = spindle(root)?;
    Ok(parts(Linkage::Rigid(RigidMount { spindle: centre }), Vec::new(), mass, spin, None))
}

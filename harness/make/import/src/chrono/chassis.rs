//! The sprung body.

use super::json::Node;
use super::set::{Set, template};
use crate::hull;
use crate::place::{self, IDENTITY, Mass, Matrix, add, quaternion, scale, turn};
use crate::{ImportError, Notes};
use vb_vehicle::Point;

/// The chassis in the source's frame.
#[derive(Debug)]
pub(crate) struct Body {
    pub(crate) mass: Mass,
    pub(crate) seat: Option<Point>,
    /// Convex parts; empty if the source has none.
    pub(crate) hull: Vec<Vec<Point>>,
    pub(crate) friction: Option<f64>,
}

/// Reads a chassis.
pub(crate) fn read(set: &Set, root: &Node, notes: &mut Notes) -> Result<Body, ImportError> {
    let name = template(root.doc())?;
    if name != "RigidChassis" {
        return root.fail(format!("no counterpart of the template {name:?}; use RigidChassis"));
    }
    let components = root.need("Components")?;
    let mut mass = Mass::default();
    for c in components.items()? {
        let frame = c.need("Centroidal Frame")?;
        let at = frame.pt("Location")?;
        let axes = frame.get("Orientation").map_or(Ok(IDENTITY), |n| n.quaternion().map(quaternion))?;
        let [xx, yy, zz] = c.pt("Moments of Inertia")?;
        let [xy, xz, yz] = c.get("Products of Inertia").map_or(Ok([0.0; 3]), |n| n.point())?;
        let own: Matrix = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
        let turned = place::product(&place::product(&axes, &own), &place::transposed(&axes));
        let void = c.get("Void").map_or(Ok(false), |n| n.flag())?;
        let mut part = Mass::body(c.num("Mass")?, at, &turned);
        if void {
            part = Mass::body(-part.mass, at, &turned.map(|r| r.map(|x| -x)));
        }
        mass = mass.plus(&part);
    }
    if mass.mass <= 0.0 {
        return components.fail(format!("weighs {} kg; the mass must be positive", mass.mass));
    }
    let seat = match root.get("Driver Position") {
        Some(n) => {
            if let Some(o) = n.get("Orientation") {
                o.used();
            }
            notes.chosen(format!(
                "{}: the driver's place, which Chrono's cameras use, is that of the seat",
                n.at()
            ));
            Some(n.pt("Location")?)
        }
        None => None,
    };
    let (mut parts, mut friction) = (Vec::new(), None);
    if let Some(contact) = root.get("Contact") {
        if let Some(materials) = contact.get("Materials") {
            for m in materials.items()? {
                let mu = m.num("Coefficient of Friction")?;
                friction = Some(friction.map_or(mu, |f: f64| f.max(mu)));
            }
        }
        for shape in contact.get("Shapes").map_or(Ok(Vec::new()), |n| n.items())? {
            shape.get("Material Index").inspect(Node::used);
            parts.extend(convex(set, &shape, notes)?);
        }
    }
    Ok(Body { mass, seat, hull: parts, friction })
}

/// A collision shape as convex parts.
fn convex(set: &Set, shape: &Node, notes: &mut Notes) -> Result<Vec<Vec<Point>>, ImportError> {
    let kind = shape.need("Type")?.text()?;
    let at = || shape.get("Location").map_or(Ok([0.0; 3]), |n| n.point());
    Ok(match kind {
        "BOX" => {
            let axes = shape.get("Orientation").map_or(Ok(IDENTITY), |n| n.quaternion().map(quaternion))?;
            let size = shape.pt("Dimensions")?;
            let centre = at()?;
            vec![hull::block(size).iter().map(|p| add(centre, turn(&axes, *p))).collect()]
        }
        "SPHERE" => {
            let (centre, radius) = (at()?, shape.num("Radius")?);
            vec![hull::ball(radius).iter().map(|p| add(centre, *p)).collect()]
        }
        "CYLINDER" => {
            let (centre, radius, length) = (at()?, shape.num("Radius")?, shape.num("Length")?);
            let axis = match shape.get("Orientation").filter(|_| !shape.has("Axis")) {
                Some(n) => turn(&quaternion(n.quaternion()?), [0.0, 0.0, 1.0]),
                None => shape.pt("Axis")?,
            };
            let axis = scale(axis, 1.0 / place::length(axis).max(1e-12));
            vec![hull::barrel(axis, radius, length).iter().map(|p| add(centre, *p)).collect()]
        }
        "HULL" | "MESH" => {
            shape.get("Contact Radius").inspect(Node::used);
            let centre = at()?;
            let name = shape.need("Filename")?;
            let file = name.text()?;
            let candidates = [Some(set.root.join(file)), set.root.parent().map(|p| p.join(file))];
            let Some(path) = candidates.into_iter().flatten().find(|p| p.is_file()) else {
                notes.dropped(format!("{}: {file:?} is not in the set; its shape is left out", name.at()));
                return Ok(Vec::new());
            };
            let parts = hull::mesh(&path)?;
            if kind == "MESH" {
                notes.approximated(format!(
                    "{}: the mesh is replaced by convex hulls of its groups",
                    name.at()
                ));
            }
            parts.into_iter().map(|part| part.iter().map(|p| add(centre, *p)).collect()).collect()
        }
        other => {
            notes.dropped(format!("{}: a shape of type {other:?}", shape.at()));
            Vec::new()
        }
    })
}

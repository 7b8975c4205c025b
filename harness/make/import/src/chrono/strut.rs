//! Springs and dampers ("TSDA" elements).

use super::json::Node;
use crate::place::{add, length, sub};
use crate::{ImportError, Notes};
use vb_vehicle::Point;
use vb_vehicle::suspension::{Damper, Part, Spring, Strut, StrutStops};

/// The force of Chrono's stops over the depth, m and N (SpringBistopForce of chrono_vehicle), with our steep end.
const STOP: [[f64; 2]; 11] = [
    [0.0, 0.0],
    [0.002, 200.0],
    [0.004, 400.0],
    [0.006, 600.0],
    [0.008, 800.0],
    [0.01, 1000.0],
    [0.02, 2500.0],
    [0.03, 4500.0],
    [0.04, 7500.0],
    [0.05, 12500.0],
    [0.06, 125_000.0],
];

/// Keys of the end on the moving part.
const ENDS: &[&str] =
    &["Location Arm", "Location Upright", "Location Link", "Location Axle", "Location Axle Housing"];

/// Reads the elements of these fields; elements on one line become one strut.
pub(super) fn struts(
    root: &Node,
    keys: &[&str],
    part: Part,
    notes: &mut Notes,
) -> Result<Vec<Strut>, ImportError> {
    let mut out: Vec<Strut> = Vec::new();
    for key in keys {
        let Some(node) = root.get(key) else { continue };
        let strut = element(&node, part, notes)?;
        if strut.spring.is_none() && strut.damper.is_none() {
            notes.approximated(format!("{}: has neither stiffness nor damping, and is left out", node.at()));
            continue;
        }
        let same = out.iter_mut().find(|s| {
            length(sub(s.chassis, strut.chassis)) < 1e-6
                && length(sub(s.end, strut.end)) < 1e-6
                && (s.spring.is_none() || strut.spring.is_none())
                && (s.damper.is_none() || strut.damper.is_none())
        });
        match same {
            Some(s) => {
                s.spring = s.spring.take().or(strut.spring);
                s.damper = s.damper.take().or(strut.damper);
                s.stops = s.stops.take().or(strut.stops);
            }
            None => out.push(strut),
        }
    }
    Ok(out)
}

fn element(node: &Node, part: Part, notes: &mut Notes) -> Result<Strut, ImportError> {
    let chassis = node.pt("Location Chassis")?;
    let Some(end) = node.any(ENDS) else {
        return node.fail(format!("the end on the suspension is missing (one of {})", ENDS.join(", ")));
    };
    let end = end.point()?;
    let design = length(sub(chassis, end));
    let (mapped_spring, mapped_damper) = map(node, design, notes)?;
    let spring = spring(node, notes)?.or(mapped_spring);
    let damper = damper(node, notes)?.or(mapped_damper);
    let stops = if spring.is_some() { stops(node, design, notes)? } else { None };
    Ok(Strut { chassis, end, part, spring, damper, stops })
}

/// Chrono's tables are over the extension and pull together where they are positive; ours over the compression and push apart.
pub(super) fn turned(mut table: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    table.reverse();
    let negated = |x: f64| if x == 0.0 { 0.0 } else { -x };
    let mut out: Vec<[f64; 2]> = table.iter().map(|p| p.map(negated)).collect();
    out.sort_by(|a, b| a[0].total_cmp(&b[0]));
    out
}

fn spring(node: &Node, notes: &mut Notes) -> Result<Option<Spring>, ImportError> {
    let preload = node.num_or("Preload", 0.0)?;
    let curve = node.get("Spring Curve Data").or_else(|| {
        // The older name, of springs only.
        node.get("Curve Data").filter(|_| node.has("Free Length"))
    });
    if let Some(curve) = curve {
        let points = curve.table()?;
        let free_length = node.num("Free Length")?;
        if node.has("Spring Coefficient") {
            node.num("Spring Coefficient")?;
            notes.approximated(format!("{}: the curve counts, not the coefficient, as in Chrono", node.at()));
        }
        let mut points = turned(points);
        points.iter_mut().for_each(|p| p[1] += preload);
        return Ok(Some(Spring::Table { free_length, points }));
    }
    let Some(k) = node.get("Spring Coefficient") else { return Ok(None) };
    let stiffness = k.number()?;
    if stiffness == 0.0 {
        node.num_or("Free Length", 0.0)?;
        return Ok(None);
    }
    Ok(Some(Spring::Linear { stiffness, free_length: node.num("Free Length")?, preload }))
}

fn damper(node: &Node, notes: &mut Notes) -> Result<Option<Damper>, ImportError> {
    let curve = node.get("Damping Curve Data").or_else(|| {
        node.get("Curve Data").filter(|_| !node.has("Free Length") && !node.has("Spring Curve Data"))
    });
    if let Some(curve) = curve {
        return Ok(Some(Damper::Table { points: rates(turned(curve.table()?), &curve.at(), notes) }));
    }
    let Some(c) = node.get("Damping Coefficient") else { return Ok(None) };
    let c = c.number()?;
    if c == 0.0 {
        return Ok(None);
    }
    Ok(Some(match (node.get("Degressivity Compression"), node.get("Degressivity Expansion")) {
        (Some(dc), Some(de)) => Damper::Degressive {
            compression: c,
            compression_degression: dc.number()?,
            rebound: c,
            rebound_degression: de.number()?,
        },
        _ => Damper::Linear { coefficient: c },
    }))
}

/// Rates and forces that resist: the origin is a point, and no point drives the motion.
pub(super) fn rates(mut points: Vec<[f64; 2]>, at: &str, notes: &mut Notes) -> Vec<[f64; 2]> {
    let mut changed = false;
    points.retain(|p| p[0] != 0.0 || p[1] == 0.0);
    if !points.contains(&[0.0, 0.0]) {
        let k = points.partition_point(|p| p[0] < 0.0);
        points.insert(k, [0.0, 0.0]);
        changed = true;
    }
    for p in &mut points {
        if p[0] * p[1] < 0.0 {
            p[1] = 0.0;
            changed = true;
        }
    }
    if changed {
        notes.approximated(format!(
            "{at}: the damper's table passes through zero and never drives the motion"
        ));
    }
    points
}

/// Forces over length and rate: the column at the design length.
fn map(node: &Node, design: f64, notes: &mut Notes) -> Result<(Option<Spring>, Option<Damper>), ImportError> {
    let Some(map) = node.get("Map Data") else { return Ok((None, None)) };
    map.used();
    let free = node.num_or("Free Length", 0.0)?;
    let lengths = node.need("Deformation")?.numbers()?;
    let mut still = Vec::new();
    let mut rows = Vec::new();
    for row in map.items()? {
        let values = row.numbers()?;
        if values.len() != lengths.len() + 1 || lengths.is_empty() {
            return row.fail(format!(
                "{} numbers, but a rate and {} forces are expected",
                values.len(),
                lengths.len()
            ));
        }
        let columns: Vec<[f64; 2]> = lengths.iter().zip(&values[1..]).map(|(x, f)| [*x, *f]).collect();
        let (force, _) = vb_vehicle::table::interpolate(&columns, design - free);
        if values[0] == 0.0 && columns.iter().any(|c| c[1] != 0.0) {
            still = columns;
        }
        rows.push([values[0], force]);
    }
    notes.approximated(format!(
        "{}: forces over rate are those at the design length, whatever the length is",
        node.at()
    ));
    let rest = rows.iter().find(|r| r[0] == 0.0).map_or(0.0, |r| r[1]);
    rows.iter_mut().for_each(|r| r[1] -= rest);
    rows.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let damper = Damper::Table { points: rates(turned(rows), &node.at(), notes) };
    // A deformation without a free length is the length itself.
    let spring = (still.len() > 1).then(|| {
        let centre = if free > 0.0 { free } else { design };
        let offset = if free > 0.0 { 0.0 } else { design };
        let points = still.iter().map(|c| [c[0] - offset, c[1]]).collect();
        Spring::Table { free_length: centre, points: turned(points) }
    });
    Ok((spring, Some(damper)))
}

fn stops(node: &Node, design: f64, notes: &mut Notes) -> Result<Option<StrutStops>, ImportError> {
    let (Some(least), Some(most)) = (node.get("Minimum Length"), node.get("Maximum Length")) else {
        return Ok(None);
    };
    let (mut shortest, mut longest) = (least.number()?, most.number()?);
    if shortest > longest {
        std::mem::swap(&mut shortest, &mut longest);
        notes.approximated(format!(
            "{}: Minimum Length exceeds Maximum Length; they are taken the other way round",
            node.at()
        ));
    }
    if shortest <= 0.0 || shortest == longest {
        notes.approximated(format!(
            "{}: the stops at {shortest} and {longest} m are no lengths, and are left out",
            node.at()
        ));
        return Ok(None);
    }
    if !(shortest..=longest).contains(&design) {
        notes.approximated(format!(
            "{}: the spring is {design:.3} m long at the design height, beyond its stops at {shortest} and {longest} m; they are left out",
            node.at()
        ));
        return Ok(None);
    }
    notes.approximated(format!(
        "{}: the stops have the forces of Chrono's (12.5 kN at 50 mm), and 125 kN at 60 mm, where Chrono's end",
        node.at()
    ));
    Ok(Some(StrutStops { shortest, longest, stiffness: 0.0, table: STOP.to_vec() }))
}

/// The strut that acts at the end of a link as another one does at a point of the link: `fraction` of the way from the chassis.
pub(super) fn levered(strut: &Strut, end: Point, fraction: f64) -> Strut {
    let t = fraction;
    let design = length(sub(strut.chassis, strut.end));
    let stretch = |free: f64| design + (free - design) / t;
    let spring = strut.spring.as_ref().map(|s| match s {
        Spring::Linear { stiffness, free_length, preload } => Spring::Linear {
            stiffness: stiffness * t * t,
            free_length: stretch(*free_length),
            preload: preload * t,
        },
        Spring::Progressive { stiffness, progression, free_length } => Spring::Progressive {
            stiffness: stiffness * t * t,
            progression: progression * t * t * t,
            free_length: stretch(*free_length),
        },
        Spring::Table { free_length, points } => Spring::Table {
            free_length: stretch(*free_length),
            points: points.iter().map(|p| [p[0] / t, p[1] * t]).collect(),
        },
    });
    let damper = strut.damper.as_ref().map(|d| match d {
        Damper::Linear { coefficient } => Damper::Linear { coefficient: coefficient * t * t },
        Damper::Bilinear { compression, rebound } => {
            Damper::Bilinear { compression: compression * t * t, rebound: rebound * t * t }
        }
        Damper::Degressive { compression, compression_degression, rebound, rebound_degression } => {
            Damper::Degressive {
                compression: compression * t * t,
                compression_degression: compression_degression * t,
                rebound: rebound * t * t,
                rebound_degression: rebound_degression * t,
            }
        }
        Damper::Table { points } => {
            Damper::Table { points: points.iter().map(|p| [p[0] / t, p[1] * t]).collect() }
        }
    });
    let stops = strut.stops.as_ref().map(|s| StrutStops {
        shortest: (design + (s.shortest - design) / t).max(0.01 * design),
        longest: design + (s.longest - design) / t,
        stiffness: s.stiffness * t * t,
        table: s.table.iter().map(|p| [p[0] / t, p[1] * t]).collect(),
    });
    Strut {
        chassis: add(end, sub(strut.chassis, strut.end)),
        end,
        part: Part::Upright,
        spring,
        damper,
        stops,
    }
}

#[cfg(test)]
mod tests {
    use super::super::json::Doc;
    use super::*;

    fn read(text: &str) -> (Vec<Strut>, Notes) {
        let doc = Doc::parse("s.json".to_owned(), text).unwrap();
        let mut notes = Notes::default();
        let struts = struts(&doc.root(), &["Spring", "Shock"], Part::Arm, &mut notes).unwrap();
        (struts, notes)
    }

    #[test]
    fn a_curve_over_the_extension_becomes_one_over_the_compression() {
        let (s, _) = read(
            r#"{"Spring": {"Location Chassis": [0, 0, 0.5], "Location Arm": [0, 0, 0], "Free Length": 0.6,
                "Spring Curve Data": [[-0.1, -5000], [0, -500], [0.1, 900]]},
                "Shock": {"Location Chassis": [0, 0, 0.5], "Location Arm": [0, 0, 0],
                "Damping Curve Data": [[-1, -300], [0, 0], [2, 500]]}}"#,
        );
        assert_eq!(s.len(), 1, "on one line");
        // Chrono: force = -f(length - free length), so 0.1 m shorter pushes by 5000 N.
        let spring = s[0].spring.as_ref().unwrap();
        assert!((spring.force(0.5) - 5000.0).abs() < 1e-9);
        assert!((spring.force(0.7) + 900.0).abs() < 1e-9);
        let damper = s[0].damper.as_ref().unwrap();
        assert!(
            (damper.resistance(2.0) - 250.0).abs() < 1e-9 && (damper.resistance(-1.0) - 300.0).abs() < 1e-9
        );
    }

    #[test]
    fn a_map_gives_its_column_at_the_design_length() {
        let (s, notes) = read(
            r#"{"Shock": {"Location Chassis": [0, 0, 0.3], "Location Arm": [0, 0, 0], "Deformation": [0.25, 0.35],
                "Map Data": [[-1, -100, -300], [0, 0, 0], [1, 400, 600]]}}"#,
        );
        let Some(Damper::Table { points }) = &s[0].damper else { panic!("{:?}", s[0].damper) };
        for (p, q) in points.iter().zip([[-1.0, -500.0], [0.0, 0.0], [1.0, 200.0]]) {
            assert!((p[0] - q[0]).abs() < 1e-9 && (p[1] - q[1]).abs() < 1e-9, "{points:?}");
        }
        assert_eq!(notes.iter().count(), 1);
    }

    #[test]
    fn a_strut_on_a_link_keeps_force_and_rate_at_its_end() {
        let (s, _) = read(
            r#"{"Spring": {"Location Chassis": [0, 0, 0.4], "Location Arm": [0, 0, 0], "Free Length": 0.5, "Spring Coefficient": 10000}}"#,
        );
        let l = levered(&s[0], [1.0, 0.0, 0.0], 0.5);
        let spring = l.spring.unwrap();
        // 1000 N at half the link are 500 N at its end, and 10 kN/m are 2.5 kN/m.
        assert!((spring.force(0.4) - 500.0).abs() < 1e-9 && (spring.force(0.3) - 750.0).abs() < 1e-9);
    }
}

//! The forces of springs, dampers and stops along a strut.

use crate::suspension::{Damper, Spring, Stops, Strut, StrutStops, Suspension};

/// Straight lines between points of increasing abscissa, going on beyond the ends.
#[inline]
fn line(points: &[[f64; 2]], x: f64) -> f64 {
    if points.len() < 2 {
        return points.first().map_or(0.0, |p| p[1]);
    }
    let i = points.partition_point(|p| p[0] <= x).clamp(1, points.len() - 1);
    let ([x0, y0], [x1, y1]) = (points[i - 1], points[i]);
    y0 + (y1 - y0) * (x - x0) / (x1 - x0)
}

impl Spring {
    /// The force with which the spring pushes the ends apart at a length (m), N.
    #[must_use]
    #[inline]
    pub fn force(&self, length: f64) -> f64 {
        match self {
            Self::Linear { stiffness, free_length, preload } => preload + stiffness * (free_length - length),
            Self::Progressive { stiffness, progression, free_length } => {
                let e = free_length - length;
                stiffness * e + progression * e * e.abs()
            }
            Self::Table { free_length, points } => line(points, free_length - length),
        }
    }
}

impl Damper {
    /// The force over the rate, N s/m, at a rate of the length (m/s, positive when extending); it is never negative.
    /// Multiplied by the rate at the end of a step, it dissipates energy whatever the step.
    #[must_use]
    #[inline]
    pub fn resistance(&self, rate: f64) -> f64 {
        match self {
            Self::Linear { coefficient } => *coefficient,
            Self::Bilinear { compression, rebound } => {
                if rate > 0.0 {
                    *rebound
                } else {
                    *compression
                }
            }
            Self::Degressive { compression, compression_degression, rebound, rebound_degression } => {
                if rate > 0.0 {
                    rebound / (1.0 + rebound_degression * rate)
                } else {
                    compression / (1.0 - compression_degression * rate)
                }
            }
            Self::Table { points } => {
                // Close to rest the slope there, which the quotient tends to.
                let v = if rate.abs() > 1e-4 { -rate } else { 1e-4 };
                (line(points, v) / v).max(0.0)
            }
        }
    }
}

#[inline]
fn stop(stiffness: f64, table: &[[f64; 2]], depth: f64) -> f64 {
    stiffness * depth + line(table, depth)
}

impl StrutStops {
    /// The force with which the stops push the ends apart at a length (m), N; negative where they pull them together.
    #[must_use]
    #[inline]
    pub fn force(&self, length: f64) -> f64 {
        if length < self.shortest {
            stop(self.stiffness, &self.table, self.shortest - length)
        } else if length > self.longest {
            -stop(self.stiffness, &self.table, length - self.longest)
        } else {
            0.0
        }
    }
}

impl Stops {
    /// The force with which the stops push the wheel down at a travel (m, compression positive), N; negative where they
    /// pull it up.
    #[must_use]
    #[inline]
    pub fn force(&self, travel: f64) -> f64 {
        if travel > self.jounce {
            stop(self.stiffness, &self.table, travel - self.jounce)
        } else if travel < self.rebound {
            -stop(self.stiffness, &self.table, self.rebound - travel)
        } else {
            0.0
        }
    }
}

/// The spring, the damper and the stops that act along one strut or about an arm.
#[derive(Clone, Debug, Default)]
pub struct Element {
    spring: Option<Spring>,
    damper: Option<Damper>,
    stops: Option<StrutStops>,
}

impl Element {
    /// The force of the spring and the stops at a length (m), N; positive pushes the ends apart.
    #[inline]
    #[must_use]
    pub fn force(&self, length: f64) -> f64 {
        let spring = self.spring.as_ref().map_or(0.0, |s| s.force(length));
        spring + self.stops.as_ref().map_or(0.0, |s| s.force(length))
    }

    /// The resistance of the damper at a rate of the length (m/s, positive when extending), N s/m.
    #[inline]
    #[must_use]
    pub fn resistance(&self, rate: f64) -> f64 {
        self.damper.as_ref().map_or(0.0, |d| d.resistance(rate))
    }
}

impl From<&Strut> for Element {
    fn from(s: &Strut) -> Self {
        Self { spring: s.spring.clone(), damper: s.damper.clone(), stops: s.stops.clone() }
    }
}

/// The elements of a suspension in the order in which the tables hold their lengths. A torsion bar comes first; its
/// length is the arm's angle (rad), taken negative.
#[must_use]
pub fn elements(suspension: &Suspension) -> Vec<Element> {
    let torsion = suspension.linkage.torsion().map(|t| Element {
        spring: Some(Spring::Linear { stiffness: t.stiffness, free_length: 0.0, preload: t.preload }),
        damper: Some(Damper::Linear { coefficient: t.damping }),
        stops: None,
    });
    torsion.into_iter().chain(suspension.struts.iter().map(Element::from)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn springs_follow_their_laws_in_compression_and_tension() {
        let linear = Spring::Linear { stiffness: 100.0, free_length: 0.5, preload: 7.0 };
        assert!((linear.force(0.4) - 17.0).abs() < 1e-12);
        // F = k1 e + k2 e|e|, as in chrono_models/vehicle/man. The truck's front spring at its design length, sheet
        // man5t: 28205 N.
        let truck = Spring::Progressive { stiffness: 85490.0, progression: 495_208.0, free_length: 0.667 };
        assert!((truck.force(0.567) - (8549.0 + 4952.08)).abs() < 1e-9);
        assert!((truck.force(0.767) + (8549.0 + 4952.08)).abs() < 1e-9);
        let table = Spring::Table { free_length: 0.3, points: vec![[-0.1, -50.0], [0.0, 0.0], [0.1, 200.0]] };
        for (length, force) in [(0.25, 100.0), (0.35, -25.0), (0.1, 400.0), (0.5, -100.0)] {
            assert!((table.force(length) - force).abs() < 1e-9, "{length}: {}", table.force(length));
        }
    }

    #[test]
    fn dampers_resist_each_direction_by_its_own_law() {
        let bilinear = Damper::Bilinear { compression: 10.0, rebound: 30.0 };
        assert_eq!((bilinear.resistance(-2.0), bilinear.resistance(2.0)), (10.0, 30.0));
        // c v / (1 + n v), as in chrono_models/vehicle/man.
        let degressive = Damper::Degressive {
            compression: 52526.6,
            compression_degression: 3.0,
            rebound: 98727.9,
            rebound_degression: 4.77954,
        };
        assert!((degressive.resistance(0.5) - 98727.9 / (1.0 + 4.77954 * 0.5)).abs() < 1e-9);
        assert!((degressive.resistance(-0.5) - 52526.6 / 2.5).abs() < 1e-9);
        let table = Damper::Table { points: vec![[-1.0, -300.0], [0.0, 0.0], [1.0, 100.0]] };
        assert!((table.resistance(0.5) - 300.0).abs() < 1e-9, "extending");
        assert!((table.resistance(-2.0) - 100.0).abs() < 1e-9, "compressing, beyond the last point");
        assert!((table.resistance(0.0) - 100.0).abs() < 1e-6);
    }

    #[test]
    fn stops_act_only_beyond_their_ends() {
        let stops = StrutStops {
            shortest: 0.3,
            longest: 0.6,
            stiffness: 0.0,
            table: vec![[0.0, 0.0], [0.01, 1000.0], [0.02, 2500.0]],
        };
        assert_eq!(stops.force(0.45), 0.0);
        assert!((stops.force(0.285) - 1750.0).abs() < 1e-9);
        assert!((stops.force(0.61) + 1000.0).abs() < 1e-9);
        assert!((stops.force(0.27) - 4000.0).abs() < 1e-9, "goes on beyond the last point");
    }
}

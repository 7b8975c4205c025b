//! Transverse Mercator of the UTM zones with the same bits on every platform, which heights of a world may depend on.
//!
//! Krüger's series to the fourth power of the third flattening (C. F. F. Karney, Transverse Mercator with an accuracy of a few
//! nanometers, J. Geodesy 85, 2011, eqs. 7 to 35), which is below a micrometre in a zone.

use vb_math::{asin, atan2, cos, exp, ln, sin};

/// Scale on the central meridian of a zone.
const SCALE: f64 = 0.9996;
/// Easting of the central meridian, m.
const EASTING: f64 = 500_000.0;
/// Northing of the equator in the south, m.
const SOUTH: f64 = 10_000_000.0;

/// An ellipsoid of revolution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ellipsoid {
    /// Semi-major axis, m.
    pub(crate) a: f64,
    /// Flattening.
    pub(crate) f: f64,
}

impl Ellipsoid {
    pub(crate) const WGS84: Self = Self { a: 6_378_137.0, f: 1.0 / 298.257_223_563 };
}

/// A zone of UTM.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Zone {
    /// 1 to 60, from 180° west on.
    pub(crate) number: u8,
    pub(crate) south: bool,
    ellipsoid: Ellipsoid,
}

impl Zone {
    /// The zone of a place (degrees); `None` beyond 84° north and 80° south.
    pub(crate) fn of(lon: f64, lat: f64, ellipsoid: Ellipsoid) -> Option<Self> {
        let turns = (lon + 180.0) / 360.0;
        let lon = 360.0 * (turns - turns.floor());
        let number = (lon / 6.0).floor().clamp(0.0, 59.0) as u8 + 1;
        (-80.0..=84.0).contains(&lat).then_some(Self { number, south: lat < 0.0, ellipsoid })
    }

    /// Degrees.
    pub(crate) fn central_meridian(&self) -> f64 {
        f64::from(self.number) * 6.0 - 183.0
    }

    fn third_flattening(&self) -> f64 {
        self.ellipsoid.f / (2.0 - self.ellipsoid.f)
    }

    /// Radius of the circle with the meridian's length, times the scale; m.
    fn radius(&self) -> f64 {
        let n = self.third_flattening();
        SCALE * self.ellipsoid.a / (1.0 + n) * (1.0 + n * n / 4.0 + n * n * n * n / 64.0)
    }

    /// Easting and northing (m) of a place (degrees).
    pub(crate) fn project(&self, [lon, lat]: [f64; 2]) -> [f64; 2] {
        let n = self.third_flattening();
        let [n2, n3, n4] = [n * n, n * n * n, n * n * n * n];
        let series = [
            n / 2.0 - 2.0 * n2 / 3.0 + 5.0 * n3 / 16.0 + 41.0 * n4 / 180.0,
            13.0 * n2 / 48.0 - 3.0 * n3 / 5.0 + 557.0 * n4 / 1440.0,
            61.0 * n3 / 240.0 - 103.0 * n4 / 140.0,
            49561.0 * n4 / 161_280.0,
        ];
        let turns = (lon - self.central_meridian()) / 360.0;
        let (phi, lambda) = (lat.to_radians(), (360.0 * (turns - turns.round())).to_radians());
        let e = 2.0 * n.sqrt() / (1.0 + n);
        let s = sin(phi);
        let t = sinh(atanh(s) - e * atanh(e * s));
        let (xi, eta) = (atan2(t, cos(lambda)), atanh(sin(lambda) / (1.0 + t * t).sqrt()));
        let (mut north, mut east) = (xi, eta);
        for (k, a) in series.into_iter().enumerate() {
            let j = 2.0 * (k + 1) as f64;
            north += a * sin(j * xi) * cosh(j * eta);
            east += a * cos(j * xi) * sinh(j * eta);
        }
        let radius = self.radius();
        [EASTING + radius * east, radius * north + if self.south { SOUTH } else { 0.0 }]
    }

    /// Longitude and latitude (degrees) of an easting and a northing (m).
    pub(crate) fn unproject(&self, [east, north]: [f64; 2]) -> [f64; 2] {
        let n = self.third_flattening();
        let [n2, n3, n4] = [n * n, n * n * n, n * n * n * n];
        let series = [
            n / 2.0 - 2.0 * n2 / 3.0 + 37.0 * n3 / 96.0 - n4 / 360.0,
            n2 / 48.0 + n3 / 15.0 - 437.0 * n4 / 1440.0,
            17.0 * n3 / 480.0 - 37.0 * n4 / 840.0,
            4397.0 * n4 / 161_280.0,
        ];
        let latitude = [
            2.0 * n - 2.0 * n2 / 3.0 - 2.0 * n3 + 116.0 * n4 / 45.0,
            7.0 * n2 / 3.0 - 8.0 * n3 / 5.0 - 227.0 * n4 / 45.0,
            56.0 * n3 / 15.0 - 136.0 * n4 / 35.0,
            4279.0 * n4 / 630.0,
        ];
        let radius = self.radius();
        let xi = (north - if self.south { SOUTH } else { 0.0 }) / radius;
        let eta = (east - EASTING) / radius;
        let (mut x, mut y) = (xi, eta);
        for (k, b) in series.into_iter().enumerate() {
            let j = 2.0 * (k + 1) as f64;
            x -= b * sin(j * xi) * cosh(j * eta);
            y -= b * cos(j * xi) * sinh(j * eta);
        }
        let chi = asin((sin(x) / cosh(y)).clamp(-1.0, 1.0));
        let terms = latitude.into_iter().enumerate().map(|(k, d)| d * sin(2.0 * (k + 1) as f64 * chi));
        let phi = chi + terms.sum::<f64>();
        let lambda = atan2(sinh(y), cos(x));
        [self.central_meridian() + lambda.to_degrees(), phi.to_degrees()]
    }
}

fn sinh(x: f64) -> f64 {
    0.5 * (exp(x) - exp(-x))
}

fn cosh(x: f64) -> f64 {
    0.5 * (exp(x) + exp(-x))
}

fn atanh(x: f64) -> f64 {
    0.5 * ln((1.0 + x) / (1.0 - x))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::crs::Crs;

    /// `proj4rs` has the projection from PROJ.
    #[test]
    fn it_agrees_with_proj_and_comes_back() {
        for (code, lon, lat) in [
            (32632, 10.9, 47.3),
            (32632, 6.1, -0.0),
            (32613, -105.3, 40.1),
            (32719, -70.2, -33.4),
            (32601, -179.9, 65.0),
        ] {
            let zone = Zone::of(lon, lat, Ellipsoid::WGS84).expect("a zone");
            let code = if zone.south { 32700 } else { 32600 } + u16::from(zone.number).max(code % 100);
            let [east, north] = zone.project([lon, lat]);
            let place = Crs::epsg(code).and_then(|crs| crs.lon_lat([east, north])).expect("a place");
            assert!((place[0] - lon).abs() < 1e-9 && (place[1] - lat).abs() < 1e-9, "{code}: {place:?}");
            let back = zone.unproject([east, north]);
            assert!((back[0] - lon).abs() < 1e-10 && (back[1] - lat).abs() < 1e-10, "{code}: {back:?}");
        }
        assert_eq!(Zone::of(-105.3, 40.1, Ellipsoid::WGS84).map(|z| z.number), Some(13));
        assert_eq!(Zone::of(0.0, 88.0, Ellipsoid::WGS84), None);
    }
}

//! Coordinate reference systems of surveys: units, local scale and places on the globe.
//!
//! Definitions come from `crs-definitions` (EPSG codes), projections and datum shifts from `proj4rs`. Both inform about places;
//! no world depends on a bit of their results, which follow the platform's mathematics.

use proj4rs::Proj;
use proj4rs::transform::transform;

use crate::utm;

/// Metres in a US survey foot.
pub const US_FOOT: f64 = 1200.0 / 3937.0;
/// Metres in an international foot.
pub const FOOT: f64 = 0.3048;

/// A unit of length.
#[derive(Clone, Debug, PartialEq)]
pub struct Length {
    /// Metres in the unit, positive.
    pub metres: f64,
    /// The symbol or name of the unit.
    pub name: String,
}

impl Length {
    #[must_use]
    pub fn metre() -> Self {
        Self { metres: 1.0, name: "m".into() }
    }

    fn new(metres: f64, name: &str) -> Self {
        Self { metres, name: name.into() }
    }

    /// A unit by its EPSG code (EPSG dataset, units of measure of the type length).
    #[must_use]
    pub fn epsg(code: u16) -> Option<Self> {
        let (metres, name) = match code {
            9001 => (1.0, "m"),
            1025 => (1e-3, "mm"),
            1033 => (1e-2, "cm"),
            9002 => (FOOT, "ft"),
            9003 => (US_FOOT, "US survey ft"),
            9005 => (0.304_797_265_4, "Clarke's ft"),
            9014 => (1.8288, "fathom"),
            9030 => (1852.0, "nautical mile"),
            9031 => (1.000_013_596_5, "German legal m"),
            9034 => (66.0 * US_FOOT, "US survey chain"),
            9035 => (5280.0 * US_FOOT, "US survey mile"),
            9036 => (1000.0, "km"),
            9037 => (0.914_391_796_2, "Clarke's yd"),
            9038 => (20.116_619_497_6, "Clarke's chain"),
            9039 => (0.201_166_195_164, "Clarke's link"),
            9040 => (0.914_398_414_616_028_7, "British yd (Sears 1922)"),
            9041 => (0.304_799_471_538_676_2, "British ft (Sears 1922)"),
            9042 => (20.116_765_121_552_632, "British chain (Sears 1922)"),
            9043 => (0.201_167_651_215_526_3, "British link (Sears 1922)"),
            9050 => (0.914_399_204_289_812_4, "British yd (Benoit 1895 A)"),
            9051 => (0.304_799_734_763_270_8, "British ft (Benoit 1895 A)"),
            9060 => (0.914_399_204_6, "British yd (Benoit 1895 B)"),
            9061 => (0.304_799_735, "British ft (Benoit 1895 B)"),
            9070 => (0.304_800_833_333_333_3, "British ft (1865)"),
            9080 => (0.304_799_510_248_146_94, "Indian ft"),
            9081 => (0.304_799_51, "Indian ft (1937)"),
            9082 => (0.304_799_6, "Indian ft (1962)"),
            9083 => (0.304_799_5, "Indian ft (1975)"),
            9084 => (0.914_398_530_744_440_8, "Indian yd"),
            9093 => (1609.344, "mile"),
            9094 => (0.304_799_710_181_508_8, "Gold Coast ft"),
            9095 => (0.304_800_749_1, "British ft (1936)"),
            9096 => (0.9144, "yd"),
            9097 => (20.1168, "chain"),
            9098 => (0.201_168, "link"),
            _ => return None,
        };
        Some(Self::new(metres, name))
    }

    /// A unit by the name that files and programs write, in any case.
    #[must_use]
    pub fn named(text: &str) -> Option<Self> {
        let plain: String = text.to_ascii_lowercase().chars().filter(char::is_ascii_alphanumeric).collect();
        let (metres, name) = match plain.as_str() {
            "m" | "metre" | "metres" | "meter" | "meters" | "mtr" => (1.0, "m"),
            "mm" | "millimetre" | "millimetres" | "millimeter" | "millimeters" => (1e-3, "mm"),
            "cm" | "centimetre" | "centimetres" | "centimeter" | "centimeters" => (1e-2, "cm"),
            "dm" | "decimetre" | "decimetres" | "decimeter" | "decimeters" => (0.1, "dm"),
            "km" | "kilometre" | "kilometres" | "kilometer" | "kilometers" => (1000.0, "km"),
            "ft" | "foot" | "feet" | "ift" | "footint" | "footinternational" | "internationalfoot"
            | "internationalfeet" | "footintl" => (FOOT, "ft"),
            "usft" | "ftus" | "sft" | "sfoot" | "footus" | "usfoot" | "usfeet" | "feetus"
            | "ussurveyfoot" | "ussurveyfeet" | "surveyfoot" | "surveyfeet" | "ftussurvey"
            | "footussurvey" | "usft1" => (US_FOOT, "US survey ft"),
            "in" | "inch" | "inches" => (0.0254, "in"),
            "yd" | "yard" | "yards" => (0.9144, "yd"),
            "fathom" | "fathoms" => (1.8288, "fathom"),
            _ => return None,
        };
        Some(Self::new(metres, name))
    }

    /// A unit of this many metres: one with a name if there is one within a hundred-millionth.
    #[must_use]
    pub fn of(metres: f64) -> Self {
        let codes = [9001, 9002, 9003, 9005, 9036, 9041, 9084, 9094, 1025, 1033];
        let known = codes.into_iter().filter_map(Self::epsg);
        let mut near = known.filter(|u| (u.metres / metres - 1.0).abs() < 1e-8);
        near.next().unwrap_or_else(|| Self { metres, name: format!("{metres} m") })
    }
}

/// The unit of heights in a vertical system.
#[derive(Clone, Debug, PartialEq)]
pub enum Vertical {
    /// Heights upwards in this unit.
    Height(Length),
    Depth,
}

impl Vertical {
    /// The unit of a vertical system by its EPSG code: those of the dataset (v11) whose heights are not metres upwards are
    /// listed; codes of other ranges are `None`.
    #[must_use]
    pub fn epsg(code: u16) -> Option<Self> {
        Some(match code {
            5702 | 6360 | 8052 => Self::Height(Length::new(US_FOOT, "US survey ft")),
            6130..=6132 | 8050 | 8228 => Self::Height(Length::new(FOOT, "ft")),
            5754 => Self::Height(Length::new(0.304_800_749_1, "British ft (1936)")),
            5336
            | 5612
            | 5614
            | 5706
            | 5715
            | 5734
            | 5739
            | 5789
            | 5831
            | 5861..=5867
            | 5873
            | 6357..=6359
            | 7976
            | 8051
            | 8053
            | 8358
            | 9287
            | 9288
            | 9672
            | 10150
            | 10151
            | 10349
            | 10364
            | 10370..=10378 => Self::Depth,
            // Orthometric heights of GeoTIFF 1.0 (5001 to 5099 are ellipsoidal heights), EPSG's vertical systems.
            5001..=5299 | 3855..=3900 | 4440 | 4458 | 5193..=5850 | 6000..=10999 => {
                Self::Height(Length::metre())
            }
            _ => return None,
        })
    }
}

/// A coordinate reference system.
#[derive(Clone, Debug, PartialEq)]
pub struct Crs {
    /// The name that others know it by, such as EPSG:32632.
    pub name: String,
    /// The definition as a string of PROJ; `None` if it is unknown.
    pub proj: Option<String>,
    /// Whether coordinates are longitudes and latitudes and not lengths.
    pub geographic: bool,
    /// Metres in a unit of its coordinates, or degrees in a unit of a geographic system; positive.
    pub unit: f64,
    /// The unit of heights of a compound system.
    pub heights: Option<Length>,
}

impl Crs {
    #[must_use]
    pub fn epsg(code: u16) -> Option<Self> {
        let definition = crs_definitions::from_code(code)?;
        Self::from_proj(format!("EPSG:{code}"), definition.proj4)
    }

    /// WGS 84 longitudes and latitudes, degrees.
    #[must_use]
    pub fn wgs84() -> Self {
        let proj = Some("+proj=longlat +datum=WGS84 +no_defs".to_owned());
        Self { name: "EPSG:4326".into(), proj, geographic: true, unit: 1.0, heights: None }
    }

    /// A system as a user names it: EPSG:CODE, a code alone, or a string of PROJ.
    ///
    /// # Errors
    /// Returns a sentence on why there is no such system.
    pub fn parse(text: &str) -> Result<Self, String> {
        let text = text.trim();
        if text.starts_with("+proj=") {
            let known = Self::from_proj(text.to_owned(), text)
                .filter(|crs| crs.geographic || crs.projection().is_some());
            return known.ok_or_else(|| format!("{text:?} is not a supported coordinate reference system"));
        }
        let code = text.to_ascii_uppercase();
        let code = code.strip_prefix("EPSG:").unwrap_or(&code).parse::<u16>().ok();
        code.and_then(Self::epsg).ok_or_else(|| {
            format!("{text:?} is not a known coordinate reference system: give EPSG:CODE, e.g. EPSG:32632, or a PROJ string")
        })
    }

    fn from_proj(name: String, proj: &str) -> Option<Self> {
        let field =
            |key: &str| proj.split_whitespace().find_map(|word| word.strip_prefix(key)?.strip_prefix('='));
        let length = |unit: Option<&str>, size: Option<&str>| match (unit, size) {
            (_, Some(size)) => size.parse::<f64>().ok().filter(|m| m.is_finite() && *m > 0.0),
            (Some(unit), None) => match unit {
                "link" => Some(0.201_168),
                other => Length::named(other).map(|u| u.metres),
            },
            (None, None) => Some(1.0),
        };
        let kind = field("+proj")?;
        if kind == "geocent" {
            return None;
        }
        let geographic = matches!(kind, "longlat" | "latlong" | "lonlat" | "latlon");
        let unit = if geographic { 1.0 } else { length(field("+units"), field("+to_meter"))? };
        let heights = match (field("+vunits"), field("+vto_meter")) {
            (None, None) => None,
            (unit, size) => length(unit, size).map(Length::of),
        };
        Some(Self { name, proj: Some(proj.to_owned()), geographic, unit, heights })
    }

    /// The system of the UTM zone about a longitude, on the datum of this geographic one.
    pub(crate) fn utm(&self, zone: u8, south: bool) -> Self {
        let own = self.proj.as_deref().unwrap_or("+proj=longlat +datum=WGS84 +no_defs");
        let code = match own {
            _ if own.contains("+datum=WGS84") => Some(if south { 32700 } else { 32600 } + u16::from(zone)),
            _ if self.name == "EPSG:4269" && !south && zone <= 23 => Some(26900 + u16::from(zone)),
            _ if self.name == "EPSG:4258" && !south && (28..=38).contains(&zone) => {
                Some(25800 + u16::from(zone))
            }
            _ => None,
        };
        let hemisphere = if south { 'S' } else { 'N' };
        let name = code
            .map_or_else(|| format!("UTM zone {zone}{hemisphere} on {}", self.name), |c| format!("EPSG:{c}"));
        let mut proj = format!("+proj=utm +zone={zone}");
        if south {
            proj.push_str(" +south");
        }
        let kept = own.split_whitespace().filter(|w| {
            !w.starts_with("+proj") && !w.starts_with("+vunits") && !w.starts_with("+geoidgrids")
        });
        for word in kept.filter(|w| *w != "+no_defs" && *w != "+type=crs") {
            proj.push(' ');
            proj.push_str(word);
        }
        proj.push_str(" +units=m +no_defs");
        Self { name, proj: Some(proj), geographic: false, unit: 1.0, heights: None }
    }

    /// Semi-major axis (m) and flattening of the ellipsoid; those of WGS 84 where the definition says nothing known.
    pub(crate) fn ellipsoid(&self) -> utm::Ellipsoid {
        let proj = self.proj.as_deref().unwrap_or_default();
        let field = |key: &str| proj.split_whitespace().find_map(|w| w.strip_prefix(key)?.strip_prefix('='));
        let named = match field("+ellps").or(field("+datum")) {
            Some("intl") => (6_378_388.0, 297.0),
            Some("clrk66" | "NAD27") => (6_378_206.4, 294.978_698_213_898_2),
            Some("bessel" | "potsdam") => (6_377_397.155, 299.152_812_8),
            Some("airy" | "OSGB36") => (6_377_563.396, 299.324_964_6),
            Some("krass") => (6_378_245.0, 298.3),
            Some("clrk80" | "clrk80ign") => (6_378_249.2, 293.466_021_293_626_9),
            Some("GRS80" | "NAD83") => (6_378_137.0, 298.257_222_101),
            _ => (6_378_137.0, 298.257_223_563),
        };
        utm::Ellipsoid { a: named.0, f: 1.0 / named.1 }
    }

    /// The projection, without grids of shifts, which are files of their own.
    fn projection(&self) -> Option<Proj> {
        let proj = self.proj.as_deref()?;
        let dropped = ["+geoidgrids", "+nadgrids", "+vunits", "+vto_meter", "+wktext", "+type"];
        let words = proj.split_whitespace().filter(|w| !dropped.iter().any(|d| w.starts_with(d)));
        let text =
            words.collect::<Vec<_>>().join(" ").replace("+proj=webmerc", "+proj=merc +a=6378137 +b=6378137");
        Proj::from_proj_string(&text).ok()
    }

    /// Whether its projection is one of maps of the world, whose unit is none on the ground, and not one of surveys.
    pub(crate) fn is_for_maps(&self) -> bool {
        let kinds = ["merc", "webmerc", "eqc", "cea", "eqearth", "sinu", "mill", "moll", "robin"];
        let kind = self.proj.as_deref().and_then(|p| p.split_whitespace().next()?.strip_prefix("+proj="));
        kind.is_some_and(|kind| kinds.contains(&kind))
    }

    /// The way from coordinates of this system to longitudes and latitudes; `None` if the definition is unknown.
    #[must_use]
    pub fn to_globe(&self) -> Option<Globe> {
        let from = self.projection()?;
        // Web Mercator takes latitudes of WGS 84 for those of its sphere: there is no datum to shift.
        let sphere = self.proj.as_deref().is_some_and(|p| p.contains("+b=6378137") || p.contains("webmerc"));
        let to = if sphere {
            "+proj=longlat +a=6378137 +b=6378137 +no_defs"
        } else {
            "+proj=longlat +datum=WGS84 +no_defs"
        };
        let degrees = self.geographic.then_some(self.unit);
        Some(Globe { from, to: Proj::from_proj_string(to).ok()?, degrees })
    }

    /// Longitude and latitude (WGS 84, degrees) of a place in this system; `None` where the system or the place has none.
    #[must_use]
    pub fn lon_lat(&self, at: [f64; 2]) -> Option<[f64; 2]> {
        self.to_globe()?.lon_lat(at)
    }

    /// Metres on the ground for a unit of the coordinates along x and along y about a place, to a millionth. 1 to some thousandths
    /// in systems for surveys; 1 / cos(latitude) in Mercator's. `None` if it can't be said.
    #[must_use]
    pub fn ground(&self, at: [f64; 2]) -> Option<[f64; 2]> {
        let step = 100.0 / self.unit;
        let globe = self.to_globe()?;
        let middle = globe.lon_lat(at)?;
        let utm::Ellipsoid { a, f } = utm::Ellipsoid::WGS84;
        let (e2, sin) = (f * (2.0 - f), vb_math::sin(middle[1].to_radians()));
        let w = 1.0 - e2 * sin * sin;
        let (prime, meridian) = (a / w.sqrt(), a * (1.0 - e2) / (w * w.sqrt()));
        let along = |towards: [f64; 2]| {
            let end = globe.lon_lat([at[0] + towards[0], at[1] + towards[1]])?;
            let start = globe.lon_lat([at[0] - towards[0], at[1] - towards[1]])?;
            let east = (end[0] - start[0]).to_radians() * prime * vb_math::cos(middle[1].to_radians());
            let north = (end[1] - start[1]).to_radians() * meridian;
            let metres = vb_math::hypot(east, north) / (2.0 * step);
            Some((metres * 1e6).round() / 1e6).filter(|m| m.is_finite() && *m > 0.0)
        };
        Some([along([step, 0.0])?, along([0.0, step])?])
    }
}

/// The way from the coordinates of a system to the globe.
pub struct Globe {
    from: Proj,
    to: Proj,
    /// Degrees in a unit, of a geographic system.
    degrees: Option<f64>,
}

impl Globe {
    /// Longitude and latitude (WGS 84, degrees) of a place; `None` where it has none.
    #[must_use]
    pub fn lon_lat(&self, [x, y]: [f64; 2]) -> Option<[f64; 2]> {
        let radians = |v: f64| self.degrees.map_or(v, |unit| (v * unit).to_radians());
        let mut point = (radians(x), radians(y), 0.0);
        transform(&self.from, &self.to, &mut point).ok()?;
        let place = [point.0.to_degrees(), point.1.to_degrees()];
        let real = place.iter().all(|v| v.is_finite()) && place[0].abs() <= 360.0 && place[1].abs() <= 90.0;
        real.then_some(place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_follow_from_the_codes_of_systems() {
        let unit = |code| Crs::epsg(code).map(|crs| crs.unit);
        for code in [2225, 2263, 2867 + 24, 3418, 6423 + 5, 2272] {
            let Some(unit) = unit(code) else { continue };
            assert!(
                (unit - US_FOOT).abs() < 1e-12 || (unit - FOOT).abs() < 1e-12 || unit == 1.0,
                "{code}: {unit}"
            );
        }
        assert_eq!(unit(2225), Some(US_FOOT));
        assert_eq!(unit(2263), Some(US_FOOT));
        assert_eq!(unit(2992), Some(FOOT));
        assert_eq!(unit(32632), Some(1.0));
        assert_eq!(unit(4326), Some(1.0));
        assert!(Crs::epsg(4326).is_some_and(|crs| crs.geographic));
        assert_eq!(Vertical::epsg(6360), Some(Vertical::Height(Length::epsg(9003).expect("ftUS"))));
        assert_eq!(Vertical::epsg(8228), Some(Vertical::Height(Length::epsg(9002).expect("ft"))));
        assert_eq!(Vertical::epsg(5703), Some(Vertical::Height(Length::metre())));
        assert_eq!(Vertical::epsg(7837), Some(Vertical::Height(Length::metre())));
        assert_eq!(Vertical::epsg(5715), Some(Vertical::Depth));
    }

    /// Places from the EPSG registry's areas of use and from the definition of the systems.
    #[test]
    fn places_are_where_the_systems_say() {
        let near = |code: u16, at: [f64; 2], lon: f64, lat: f64| {
            let found = Crs::epsg(code).and_then(|crs| crs.lon_lat(at)).expect("a place");
            assert!((found[0] - lon).abs() < 2e-6 && (found[1] - lat).abs() < 2e-6, "{code}: {found:?}");
        };
        // Central meridian and equator of UTM zone 32.
        near(32632, [500_000.0, 0.0], 9.0, 0.0);
        // False origin of California zone 1 in US survey feet.
        near(2225, [6_561_666.667, 1_640_416.667], -122.0, 39.0 + 1.0 / 3.0);
        near(3857, [0.0, 0.0], 0.0, 0.0);
        near(3857, [20_037_508.342_789_244, 20_037_508.342_789_244], 180.0, 85.051_128_78);
    }

    #[test]
    fn a_metre_of_mercator_is_shorter_on_the_ground() {
        // At 60 degrees: cos(60) = 0.5, less than 0.4 % apart for sphere and ellipsoid.
        let y = 8_399_737.889_818_36;
        let [x, y] = Crs::epsg(3857).and_then(|crs| crs.ground([0.0, y])).expect("a scale");
        assert!((x - 0.5).abs() < 2e-3 && (y - 0.5).abs() < 4e-3, "{x} {y}");
        let [x, y] = Crs::epsg(32632).and_then(|crs| crs.ground([500_000.0, 5.7e6])).expect("a scale");
        assert!((x - 1.0004).abs() < 1e-5 && (y - 1.0004).abs() < 1e-5, "{x} {y}");
        let [x, _] =
            Crs::epsg(2225).and_then(|crs| crs.ground([6_561_666.667, 1_900_000.0])).expect("a scale");
        assert!((x - US_FOOT).abs() < 1e-4, "{x}");
    }
}

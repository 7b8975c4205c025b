//! Tyre property files of Adams/Tire (`.tir`).

use super::json::Node;
use crate::ImportError;
use std::collections::BTreeMap;
use std::f64::consts::E;
use std::path::Path;
use vb_math::{atan2, pow, sin_cos};

/// The values of a file, by name.
#[derive(Debug)]
pub(crate) struct Tir {
    pub(crate) file: String,
    numbers: BTreeMap<String, f64>,
    texts: BTreeMap<String, String>,
}

/// Parameters of a brush tyre derived from a Magic Formula.
pub(crate) struct Magic {
    pub(crate) radius: f64,
    pub(crate) width: f64,
    pub(crate) vertical: [f64; 2],
    pub(crate) slopes: [f64; 2],
    pub(crate) friction: f64,
    pub(crate) rolling: f64,
    pub(crate) spin: f64,
}

impl Tir {
    pub(crate) fn read(path: &Path, file: &str) -> Result<Self, ImportError> {
        let bytes = vb_files::read(path, 1 << 20).map_err(|e| ImportError::reading(path, &e))?;
        Self::parse(&String::from_utf8_lossy(&bytes), file)
    }

    fn parse(text: &str, file: &str) -> Result<Self, ImportError> {
        let (mut numbers, mut texts) = (BTreeMap::new(), BTreeMap::new());
        for line in text.lines() {
            let line = line.split(['$', '!']).next().unwrap_or("").trim();
            let Some((key, value)) = line.split_once('=') else { continue };
            let (key, value) = (key.trim().to_ascii_uppercase(), value.trim());
            match value.parse::<f64>() {
                Ok(x) if x.is_finite() => {
                    numbers.insert(key, x);
                }
                _ => {
                    texts.insert(key, value.trim_matches('\'').trim().to_ascii_lowercase());
                }
            }
        }
        let tir = Self { file: file.to_owned(), numbers, texts };
        for (key, si) in [
            ("LENGTH", &["meter", "metre", "m"][..]),
            ("FORCE", &["newton", "n"]),
            ("MASS", &["kg", "kilogram"]),
            ("TIME", &["second", "sec", "s"]),
        ] {
            if let Some(unit) = tir.texts.get(key)
                && !si.contains(&unit.as_str())
            {
                let problem = format!(
                    "{unit:?}, but only SI units are read; convert the file to metre, newton, kg and second"
                );
                return Err(ImportError::new(file, format!("[UNITS] {key}"), problem));
            }
        }
        Ok(tir)
    }

    /// The coefficients that stand in a tyre's own file, under the names of Adams/Tire.
    pub(crate) fn inline(root: &Node) -> Result<Self, ImportError> {
        let mut numbers = BTreeMap::new();
        let parts = ["Dimension", "Vertical", "Scaling Factors"];
        let coefficients = ["Longitudinal Coefficients", "Lateral Coefficients", "Rolling Coefficients"];
        for part in parts.into_iter().chain(coefficients) {
            for (key, value) in root.get(part).into_iter().flat_map(|n| n.fields()) {
                let key = key.to_ascii_uppercase().replace(' ', "_");
                let key = if key == "NOMINAL_WHEEL_LOAD" { "FNOMIN".to_owned() } else { key };
                if let Ok(x) = value.number() {
                    numbers.insert(key, x);
                }
            }
        }
        if numbers.is_empty() {
            return root.fail("neither TIR Specification File nor coefficients; give one of them");
        }
        Ok(Self { file: root.doc().file.clone(), numbers, texts: BTreeMap::new() })
    }

    fn need(&self, key: &str) -> Result<f64, ImportError> {
        let missing =
            || ImportError::new(&self.file, key, "is missing or no number; the Magic Formula needs it");
        self.numbers.get(key).copied().ok_or_else(missing)
    }

    fn or(&self, key: &str, absent: f64) -> f64 {
        self.numbers.get(key).copied().unwrap_or(absent)
    }

    /// Slopes and peaks at a load, N, per load (Pacejka 2012, ch. 4, without camber and pressure).
    pub(crate) fn brush(&self, load: f64) -> Result<Magic, ImportError> {
        let nominal = self.need("FNOMIN")? * self.or("LFZO", 1.0);
        if nominal <= 0.0 {
            return Err(ImportError::new(&self.file, "FNOMIN", "must be a positive load, N"));
        }
        let df = (load - nominal) / nominal;
        let kx = (self.need("PKX1")? + self.or("PKX2", 0.0) * df)
            * pow(E, self.or("PKX3", 0.0) * df)
            * self.or("LKX", 1.0);
        let across = self.need("PKY1")?
            * nominal
            * sin_cos(2.0 * atan2(load, self.need("PKY2")? * nominal)).0
            * self.or("LKY", 1.0);
        let mu_x = (self.need("PDX1")? + self.or("PDX2", 0.0) * df) * self.or("LMUX", 1.0);
        let mu_y = (self.need("PDY1")? + self.or("PDY2", 0.0) * df) * self.or("LMUY", 1.0);
        Ok(Magic {
            radius: self.need("UNLOADED_RADIUS")?,
            width: self.need("WIDTH")?,
            vertical: [
                self.need("VERTICAL_STIFFNESS")? * self.or("LCZ", 1.0),
                self.or("VERTICAL_DAMPING", 0.0),
            ],
            slopes: [kx.abs(), across.abs() / load],
            friction: 0.5 * (mu_x.abs() + mu_y.abs()),
            rolling: self.or("QSY1", 0.015).abs(),
            spin: self.or("IYY", 0.0),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "[UNITS]\nLENGTH ='meter'\nFORCE = 'newton'\n[MODEL]\nUNLOADED_RADIUS = 0.4 $ m\nWIDTH = 0.2\nFNOMIN = 5000\n\
        VERTICAL_STIFFNESS = 200000\nPKX1 = 20\nPKY1 = -15\nPKY2 = 2\nPDX1 = 1.1\nPDY1 = 0.9\n";

    #[test]
    fn slopes_at_the_nominal_load_are_the_coefficients() {
        let m = Tir::parse(FILE, "t.tir").unwrap().brush(5000.0).unwrap();
        assert!((m.slopes[0] - 20.0).abs() < 1e-12);
        // Ky = PKY1 Fz0 sin(2 atan(1/2)) = 0.8 PKY1 Fz0.
        assert!((m.slopes[1] - 12.0).abs() < 1e-9 && (m.friction - 1.0).abs() < 1e-12);
    }

    #[test]
    fn other_units_are_refused_by_name() {
        let e = Tir::parse(&FILE.replace("'meter'", "'mm'"), "t.tir").unwrap_err().to_string();
        assert_eq!(
            e,
            "t.tir: [UNITS] LENGTH: \"mm\", but only SI units are read; convert the file to metre, newton, kg and second"
        );
    }
}

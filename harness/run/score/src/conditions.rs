//! The settings of a run that must match for comparisons with other runs.

use std::sync::OnceLock;

use vb_record::{DataHeader, RunHeader};

use crate::Rules;

/// The settings that must be equal where planners are compared. Settings that may differ between compared runs
/// (parameters, perception, seed) are not included.
#[derive(Clone, Debug, PartialEq)]
pub struct Conditions {
    /// The vehicle and the hash of its file.
    pub vehicle: DataHeader,
    /// The factor on every length of the world.
    pub scale: f64,
    /// The time step of the simulation, s.
    pub time_step: f64,
    /// The rules and the hash of their content.
    pub rules: DataHeader,
    /// The soils and the hash of their file.
    pub soils: DataHeader,
    /// The side of the soil's memory cells (ruts), at scale 1, m.
    pub soil_resolution: f64,
}

impl Conditions {
    /// The conditions of the benchmark: the vehicle `hmmwv` at scale 1, steps of 1 ms, the rules `paper`, the soils `default` in cells
    /// of 0.1 m, all as this version has them.
    #[must_use]
    pub fn standard() -> &'static Self {
        static STANDARD: OnceLock<Conditions> = OnceLock::new();
        let file = |name: &str, text: &str| DataHeader {
            name: name.to_owned(),
            hash: vb_files::sha256(text.as_bytes()),
        };
        STANDARD.get_or_init(|| Self {
            vehicle: file("hmmwv", include_str!("../../../../tasks/vehicles/hmmwv.yaml")),
            scale: 1.0,
            time_step: 0.001,
            rules: of_rules(&Rules::paper()),
            soils: file("default", include_str!("../../../../tasks/soils/default.yaml")),
            soil_resolution: 0.1,
        })
    }

    /// The conditions of a run.
    #[must_use]
    pub fn of(header: &RunHeader) -> Self {
        Self {
            vehicle: header.vehicle.clone(),
            scale: header.scale,
            time_step: header.time_step,
            rules: DataHeader { name: header.rules.name.clone(), hash: header.rules.hash.clone() },
            soils: header.soils.clone(),
            soil_resolution: header.soil_resolution,
        }
    }

    /// The same conditions under other rules.
    #[must_use]
    pub fn under(self, rules: &Rules) -> Self {
        Self { rules: of_rules(rules), ..self }
    }

    /// Each condition in words, e.g. `time step 5 ms`; a file's hash stands behind its name if `hashed` says so.
    fn named(&self, hashed: [bool; 3]) -> [(&'static str, String); 6] {
        let file = |data: &DataHeader, hashed: bool| match hashed {
            false => data.name.clone(),
            true => format!("{} (file {})", data.name, data.hash.get(..8).unwrap_or(&data.hash)),
        };
        let [vehicle, rules, soils] = hashed;
        // Four digits: a step of 0.005 s is no whole number of milliseconds in binary.
        let rounded = |v: f64| (v * 1e4).round() / 1e4;
        [
            ("vehicle", file(&self.vehicle, vehicle)),
            ("scale", rounded(self.scale).to_string()),
            ("time step", format!("{} ms", rounded(1000.0 * self.time_step))),
            ("rules", file(&self.rules, rules)),
            ("soils", file(&self.soils, soils)),
            ("soil resolution", format!("{} m", rounded(self.soil_resolution))),
        ]
    }

    fn files(&self) -> [&DataHeader; 3] {
        [&self.vehicle, &self.rules, &self.soils]
    }

    /// The conditions that aren't the benchmark's, in words: `time step 5 ms`. If there are any, the results can't be compared with
    /// those of runs that don't have them. A changed file of a standard name has its hash behind it.
    #[must_use]
    pub fn departures(&self) -> Vec<String> {
        let standard = Self::standard();
        let changed = |[own, known]: [&DataHeader; 2]| own.name == known.name && own.hash != known.hash;
        let [a, b] = [self.files(), standard.files()];
        let hashed = [0, 1, 2].map(|k| changed([a[k], b[k]]));
        self.named(hashed)
            .into_iter()
            .zip(standard.named([false; 3]))
            .filter(|(own, known)| own.1 != known.1)
            .map(|((name, value), _)| format!("{name} {value}"))
            .collect()
    }

    /// The conditions in which some runs differ, by name with the value of each run. Files of one name that differ have their hash
    /// behind it.
    #[must_use]
    pub fn differences(all: &[Self]) -> Vec<(&'static str, Vec<String>)> {
        let Some(first) = all.first() else { return Vec::new() };
        let changed = |k: usize| {
            all.iter().any(|one| {
                all.iter().any(|other| {
                    let [a, b] = [one.files()[k], other.files()[k]];
                    a.name == b.name && a.hash != b.hash
                })
            })
        };
        let hashed = [0, 1, 2].map(changed);
        let named: Vec<_> = all.iter().map(|one| one.named(hashed)).collect();
        let names = first.named(hashed).into_iter().enumerate();
        names
            .filter(|(k, (_, value))| named.iter().any(|own| own[*k].1 != *value))
            .map(|(k, (name, _))| (name, named.iter().map(|own| own[k].1.clone()).collect()))
            .collect()
    }
}

fn of_rules(rules: &Rules) -> DataHeader {
    DataHeader { name: rules.name.clone(), hash: rules.hash() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_standard_run_has_no_departures_and_each_other_condition_is_one() {
        let standard = Conditions::standard().clone();
        assert!(standard.departures().is_empty());
        let told = |change: fn(&mut Conditions)| {
            let mut other = standard.clone();
            change(&mut other);
            other.departures().join(", ")
        };
        assert_eq!(told(|c| c.time_step = 0.005), "time step 5 ms");
        assert_eq!(told(|c| c.scale = 0.1), "scale 0.1");
        assert_eq!(told(|c| c.vehicle.name = "m113".into()), "vehicle m113");
        assert_eq!(told(|c| c.vehicle.hash = "0123456789ab".into()), "vehicle hmmwv (file 01234567)");
        assert_eq!(told(|c| c.rules.hash = "ab".into()), "rules paper (file ab)");
        assert_eq!(told(|c| c.soils.name = "wong".into()), "soils wong");
        assert_eq!(told(|c| c.soil_resolution = 0.2), "soil resolution 0.2 m");
        let release = Rules::resolve("release").unwrap();
        assert_eq!(standard.clone().under(&release).departures(), ["rules release"]);
        assert_eq!(standard.clone().under(&Rules::paper()), standard);
    }

    #[test]
    fn runs_differ_in_what_they_have_different_values_of() {
        let standard = Conditions::standard().clone();
        let coarse = Conditions { time_step: 0.005, ..standard.clone() };
        let mut changed = standard.clone();
        changed.vehicle.hash = "0123456789ab".into();
        assert!(Conditions::differences(&[standard.clone(), standard.clone()]).is_empty());
        assert_eq!(
            Conditions::differences(&[standard.clone(), coarse]),
            [("time step", vec!["1 ms".to_owned(), "5 ms".to_owned()])]
        );
        let found = Conditions::differences(&[standard, changed]);
        assert_eq!(
            (found.len(), found[0].0, found[0].1[1].as_str()),
            (1, "vehicle", "hmmwv (file 01234567)")
        );
    }
}

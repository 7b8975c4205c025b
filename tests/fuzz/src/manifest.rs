//! Manifests of submissions, held against everything that can be checked without the plugin.

use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

use vb_host::LoadError;
use vb_sense::Profile;
use vb_sim::{SoilSet, Soils};
use vb_submission::{Expected, Sampling, Shipped, Submission, verify};
use vb_vehicle::{Vehicle, VehicleSpec};
use vb_world::{Heightfield, Provenance, Suite, SuiteMeta, TerrainClass, World};

use crate::site::Site;

const ENTRY: &str = "entry";

/// The files of a submission, of which an input replaces one.
const FILES: [(&str, &[u8]); 5] = [
    ("submission.json", include_bytes!("../seeds/submission/submission.json")),
    ("run/tasks.jsonl", include_bytes!("../seeds/submission/run/tasks.jsonl")),
    ("run/summary.json", include_bytes!("../seeds/submission/run/summary.json")),
    ("run/run.json", include_bytes!("../seeds/submission/run/run.json")),
    ("report.html", include_bytes!("../seeds/submission/report.html")),
];
const TRACE: &[u8] = include_bytes!("../seeds/submission/run/traces/w001/t00.parquet");

/// What is at hand at a verification.
struct Bench {
    site: Site,
    suite: Suite,
    vehicle: Vehicle,
    soils: Soils,
    perception: Profile,
    shipped: Shipped,
}

impl Bench {
    fn new() -> Self {
        let files = FILES.map(|(name, bytes)| (PathBuf::from(ENTRY).join(name), bytes.to_vec()));
        let site = Site::new().with(files.to_vec());
        site.write(&PathBuf::from(ENTRY).join("run/traces/w001/t00.parquet"), TRACE);
        let meta = SuiteMeta {
            name: "tiny".into(),
            version: "1".into(),
            description: String::new(),
            provenance: Provenance::Authored { by: "a target".into() },
        };
        let world = World::uniform("w001", Heightfield::flat(17, 17, 1.0, 0.0), TerrainClass::Gravel, 0.8);
        let suite = Suite::write(site.path().join("suite"), &meta, &[world]).expect("a suite");
        let vehicle = include_str!("../../../tasks/vehicles/hmmwv.yaml");
        let soils = include_str!("../../../tasks/soils/default.yaml");
        let hash = String::new;
        Self {
            site,
            suite,
            vehicle: Vehicle { spec: VehicleSpec::parse(vehicle, "hmmwv").expect("a vehicle"), hash: hash() },
            soils: Soils {
                set: SoilSet::parse(soils, "default").expect("soils"),
                hash: hash(),
                resolution: 0.1,
            },
            perception: Profile::oracle(),
            shipped: Shipped { suites: Vec::new(), vehicles: [].into(), soils: hash() },
        }
    }
}

pub(crate) fn run(data: &[u8]) {
    thread_local!(static BENCH: Bench = Bench::new());
    BENCH.with(|b| {
        b.site.replacing(data, |dir| {
            let Ok(submission) = Submission::open(&dir.join(ENTRY)) else { return };
            let version = submission.manifest().run.harness_version.clone();
            let expected = Expected {
                suite: &b.suite,
                plugin_sha256: "",
                vehicle: &b.vehicle,
                soils: &b.soils,
                perception: &b.perception,
                shipped: &b.shipped,
                harness_version: &version,
            };
            let load = |_: &vb_host::Limits| Err(LoadError::NotFound { path: "plugin".into() });
            let sampling = Sampling { draw: Some((1, 1)), jobs: 1 };
            let cancel = AtomicBool::new(false);
            if let Ok(verdict) = verify(&submission, &expected, &load, &sampling, &mut |_, _, _| {}, &cancel)
            {
                assert!(!verdict.verified && verdict.findings.len() <= 100);
            }
        });
    });
}

pub(crate) fn seeds() -> Vec<Vec<u8>> {
    thread_local!(static BENCH: Bench = Bench::new());
    BENCH.with(|b| b.site.seeds())
}

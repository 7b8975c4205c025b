//! Tyres.

use crate::field::Check;
use crate::{TyreSpec, VehicleSpec};
use vb_files::Flaw;

impl Check {
    pub(super) fn tyres(&self, v: &VehicleSpec) -> Result<(), Flaw> {
        self.tyre("tyre", &v.tyre)?;
        for (name, tyre) in &v.tyres {
            self.tyre(&format!("tyres.{name}"), tyre)?;
        }
        for (i, axle) in v.axles.iter().enumerate() {
            if let Some(tyre) = &axle.tyre {
                self.tyre(&format!("axles[{i}].tyre"), tyre)?;
            } else if let Some(name) = axle.tyres.keys().next() {
                let reason = "given, but the axle has no tyre of its own".to_owned();
                return self.fail(&format!("axles[{i}].tyres.{name}"), reason);
            }
            for (name, tyre) in &axle.tyres {
                self.tyre(&format!("axles[{i}].tyres.{name}"), tyre)?;
            }
        }
        Ok(())
    }

    fn tyre(&self, at: &str, tyre: &TyreSpec) -> Result<(), Flaw> {
        self.all_positive(at, &[("radius", tyre.radius()), ("width", tyre.width())])?;
        self.not_negative(&format!("{at}.vertical_damping"), tyre.vertical_damping())?;
        tyre.check(self, at)
    }
}

//! The registry of base laws, and registries with others beside them.

use std::fmt;

use super::Family;
use crate::elastic::{ELASTIC_LAWS, ElasticLaw};
use crate::kernel::{KERNELS, Kernel};

/// Every family of the library.
pub const FAMILIES: &[&Family] = &[
    Family::KELVIN_VOIGT,
    Family::MAXWELL,
    Family::GENERALIZED_MAXWELL,
    Family::FUNG,
    Family::LATENCY,
    Family::LATENCY_POWER,
    Family::CREEP,
];

impl Family {
    /// Spring and damper side by side (eq. 2.3).
    pub const KELVIN_VOIGT: &Self = &super::kelvin_voigt::FAMILY;
    /// Spring and damper in a row (eq. 2.4).
    pub const MAXWELL: &Self = &super::maxwell::FAMILY;
    /// A spring beside springs with dampers (eq. 2.2).
    pub const GENERALIZED_MAXWELL: &Self = &super::generalized_maxwell::FAMILY;
    /// Quasi-linear viscoelasticity (eqs 2.1, 3.2, 3.3).
    pub const FUNG: &Self = &super::fung::FAMILY;
    /// The linear latency model (eqs 4.1–4.11).
    pub const LATENCY: &Self = &super::latency::FAMILY;
    /// The nonlinear latency model (eqs 7.2, 7.3, 7.11).
    pub const LATENCY_POWER: &Self = &super::latency_power::FAMILY;
    /// Creep, solved for the force (eqs 6.1, 6.2).
    pub const CREEP: &Self = &super::creep::FAMILY;
}

/// The laws that a model may name: those of the library, and of other programs beside them.
///
/// A value, not a constant: a program declares a [`Family`], an [`ElasticLaw`] or a [`Kernel`] of its own as a `static` and adds it.
#[derive(Clone)]
pub struct Laws {
    families: Vec<&'static Family>,
    elastic: Vec<&'static ElasticLaw>,
    kernels: Vec<&'static Kernel>,
}

impl Laws {
    /// Those of the library alone.
    #[must_use]
    pub fn library() -> Self {
        Self {
            families: FAMILIES.to_vec(),
            elastic: ELASTIC_LAWS.to_vec(),
            kernels: KERNELS.to_vec(),
        }
    }

    /// These and another family, last. Of two with one name the first counts.
    #[must_use]
    pub fn with(mut self, family: &'static Family) -> Self {
        self.families.push(family);
        self
    }

    /// These and another elastic response, last.
    #[must_use]
    pub fn with_elastic(mut self, law: &'static ElasticLaw) -> Self {
        self.elastic.push(law);
        self
    }

    /// These and another way to relax, last.
    #[must_use]
    pub fn with_relaxation(mut self, kernel: &'static Kernel) -> Self {
        self.kernels.push(kernel);
        self
    }

    /// Every family.
    #[must_use]
    pub fn families(&self) -> &[&'static Family] {
        &self.families
    }

    /// Every elastic response, the power law first.
    #[must_use]
    pub fn elastic(&self) -> &[&'static ElasticLaw] {
        &self.elastic
    }

    /// Every way to relax, exponentials first.
    #[must_use]
    pub fn kernels(&self) -> &[&'static Kernel] {
        &self.kernels
    }

    /// The family of this name.
    #[must_use]
    pub fn family(&self, name: &str) -> Option<&'static Family> {
        self.families.iter().copied().find(|family| family.name == name)
    }

    /// The elastic response of this name.
    #[must_use]
    pub fn elastic_law(&self, name: &str) -> Option<&'static ElasticLaw> {
        self.elastic.iter().copied().find(|law| law.name == name)
    }

    /// The way to relax of this name.
    #[must_use]
    pub fn kernel(&self, name: &str) -> Option<&'static Kernel> {
        self.kernels.iter().copied().find(|kernel| kernel.name == name)
    }

    /// Names of all families, for messages.
    #[must_use]
    pub fn names(&self) -> Vec<&'static str> {
        self.families.iter().map(|family| family.name).collect()
    }
}

impl Default for Laws {
    fn default() -> Self {
        Self::library()
    }
}

impl PartialEq for Laws {
    /// Laws are known by their names.
    fn eq(&self, other: &Self) -> bool {
        self.families == other.families
            && self.elastic == other.elastic
            && self.kernels == other.kernels
    }
}

impl fmt::Debug for Laws {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.names()).finish()
    }
}

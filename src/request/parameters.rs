//! The parameters of this version's robot, for completion and suggestions. Other robots may have other parameters.

use sr04_firmware::parameters::Parameter;

/// Names and descriptions of the parameters.
pub fn known() -> impl Iterator<Item = (&'static str, &'static str)> {
    let all = Parameter::ALL.iter();
    all.map(|one| (one.definition().name, one.about()))
}

/// The default of a parameter, in counts of its unit.
#[must_use]
pub fn default_of(name: &str) -> Option<i16> {
    let all = Parameter::ALL.iter().map(|one| one.definition());
    let named = all.into_iter().find(|one| one.name == name);
    named.map(|one| one.default)
}

/// The known name for which `name` is probably a typing error.
pub(super) fn meant(name: &str) -> Option<&'static str> {
    crate::suggest::nearest(name, known().map(|(known, _)| known)).filter(|known| *known != name)
}

//! The parameters of this version's robot, for completion and suggestions. Other robots may have others.

use sr04_firmware::parameters::Parameter;

/// The names with their descriptions.
pub fn known() -> impl Iterator<Item = (&'static str, &'static str)> {
    let all = Parameter::ALL.iter();
    all.map(|one| (one.definition().name, one.about()))
}

/// The known name that `name` is probably a typing error of.
pub(super) fn meant(name: &str) -> Option<&'static str> {
    crate::suggest::nearest(name, known().map(|(known, _)| known)).filter(|known| *known != name)
}

//! What parameters are called in this version, for offers and for slips. The robot tells itself which it has, and may have others.

use sr04_firmware::parameters::Parameter;

/// Names, each with what it is.
pub fn known() -> impl Iterator<Item = (&'static str, &'static str)> {
    let all = Parameter::ALL.iter();
    all.map(|one| (one.definition().name, one.about()))
}

/// The known name that one which is not known is a slip of.
pub(super) fn meant(name: &str) -> Option<&'static str> {
    crate::suggest::nearest(name, known().map(|(known, _)| known)).filter(|known| *known != name)
}

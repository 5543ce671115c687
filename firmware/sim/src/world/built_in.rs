//! The worlds that are part of the program.

/// Names and texts of the built-in worlds.
pub(crate) const BUILT_IN: &[(&str, &str)] = &[
    ("house", include_str!("../../worlds/house.toml")),
    ("living-room", include_str!("../../worlds/living-room.toml")),
    ("corridor", include_str!("../../worlds/corridor.toml")),
    ("open-room", include_str!("../../worlds/open-room.toml")),
    ("stairs", include_str!("../../worlds/stairs.toml")),
    ("flat", include_str!("../../worlds/flat.toml")),
    ("office", include_str!("../../worlds/office.toml")),
    ("dark-room", include_str!("../../worlds/dark-room.toml")),
];

/// Names of the built-in worlds, for messages.
pub(super) const NAMES: &str =
    "house, living-room, corridor, open-room, stairs, flat, office and dark-room";

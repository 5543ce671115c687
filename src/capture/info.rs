//! What a capture holds, at a glance.

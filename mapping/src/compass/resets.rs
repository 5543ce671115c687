//! Settings of the odometer's pose. Lines A and B report each, in either order.

/// Modulus of the count of settings in line B.
const MODULUS: u8 = 100;

/// A setting that only one of the two kinds of line has reported so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Pending {
    #[default]
    None,
    /// Line B counted a setting: the next line A has the new pose.
    Counted,
    /// Line A had a new pose: the next line B counts the setting.
    Placed,
}

/// Recognizes each setting of the pose once.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Resets {
    count: Option<u8>,
    pending: Pending,
}

impl Resets {
    /// Begins with the count of a line B.
    pub(super) fn from_count(count: u8) -> Self {
        Self {
            count: Some(count),
            pending: Pending::None,
        }
    }

    /// Takes the count of a line B.
    pub(super) fn take_count(&mut self, count: u8) {
        let before = self.count.replace(count);
        let added = before.map_or(0, |before| (count + MODULUS - before) % MODULUS);
        self.pending = match (added, self.pending) {
            (0, Pending::Counted) | (2.., _) | (1, Pending::None | Pending::Counted) => {
                Pending::Counted
            }
            (0, Pending::None | Pending::Placed) | (1, Pending::Placed) => Pending::None,
        };
    }

    /// Takes a line A, which may have the flag of a new pose; returns whether its pose is new.
    pub(super) fn take_flag(&mut self, is_flagged: bool) -> bool {
        let is_counted = self.pending == Pending::Counted;
        if is_counted {
            self.pending = Pending::None;
        } else if is_flagged {
            self.pending = Pending::Placed;
        }
        is_flagged || is_counted
    }
}

//! Frame `C`: a command, which the robot executes exactly once.
//!
//! ```text
//! C  s         M  m            mode, its letter
//! C  s         L  lll          layers: 2 zero bits, the layers to change (8 bits), those of them to allow (8); bit n is layer n
//! C  s         F  ss m         failsafe: silence in seconds, then the mode's letter
//! C  s         P  xxxxx tt     pose: a waypoint, then theta in degrees
//! C  s         S               scan
//! C  s         A  t cc dddddd  activate the staged list: tag, count, digest
//! C  s         V  kkkk vvv     set a parameter: its key, then 18 bits of two's complement
//! C  s         V  kkkk         send line P of the parameter with this key
//! C  s         N  pp           send line P of the parameter at this place, or of all if 0
//! C  s         K               store the parameters so that they survive a reset
//!    sequence  order
//! ```

use super::waypoints::{point, push_point};
use super::{Frame, Parsed, number};
use crate::Waypoint;
use crate::failsafe::Failsafe;
use crate::status_codes::{LayerMask, Mode, status_codes};
use nom::{
    Parser,
    bytes::complete::take,
    combinator::{map, map_opt, opt, rest},
};

/// Maximum value of two characters. Larger values are clamped to it, because every robot refuses it.
const FIELD_MAX: u16 = 0xFFF;

/// Minimum value of 18 bits in two's complement.
const VALUE_LEAST: i32 = -1 << 17;

/// Maximum value of 18 bits in two's complement. It is beyond every limit of a parameter, so a robot refuses clamped values.
const VALUE_MOST: i32 = (1 << 17) - 1;

/// A sequenced command.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Command {
    /// Command sequence: one more than the previous one, modulo 64; 1 for the first of a session.
    pub sequence: u8,
    /// The order to execute.
    pub order: Order,
}

/// The order in a command. Values are absolute: the whole mask, never "toggle".
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Order {
    /// Enter a mode.
    Mode(Mode),
    /// Of the layers in `which`, allow exactly those in `allowed`; leave the others unchanged.
    Layers {
        /// Layers to change.
        which: LayerMask,
        /// Layers of `which` to allow.
        allowed: LayerMask,
    },
    /// Set the robot's pose.
    Pose {
        /// X and Y, inches.
        position: Waypoint,
        /// Heading, 0 to 359 degrees.
        theta_deg: u16,
    },
    /// Turn on the spot and measure the distances all around.
    Scan,
    /// Set the failsafe against a silent ground; `None` switches it off.
    Failsafe(Option<Failsafe>),
    /// Make the staged list the active one, if tag, count and digest match. A count of 0 clears the active
    /// list and needs no staged list.
    Activate {
        /// The staged list's tag.
        tag: u8,
        /// Number of waypoints in the list.
        count: u16,
        /// [`crate::digest::digest`] of the list.
        digest: u32,
    },
    /// Set a parameter until the next reset; the robot sends its line P.
    SetParameter {
        /// [`crate::parameter::key`] of the parameter's name.
        key: u32,
        /// The new value.
        value: i32,
    },
    /// Send line P of a parameter.
    ReadParameter {
        /// [`crate::parameter::key`] of the parameter's name.
        key: u32,
    },
    /// Send line P of the parameter with a number, or of all parameters.
    ReadParameters {
        /// Number in the robot's table, from 1; 0 for all parameters.
        place: u16,
    },
    /// Save the current values of all parameters, so that they survive a reset.
    KeepParameters,
    /// An intact order that this version cannot read; refused with [`crate::telemetry::Outcome::Unknown`].
    Unknown,
}

status_codes! {
    /// The type of an order, its first letter.
    OrderType {
        /// Letter of [`Order::Mode`].
        Mode = b'M',
        /// Letter of [`Order::Layers`].
        Layers = b'L',
        /// Letter of [`Order::Failsafe`].
        Failsafe = b'F',
        /// Letter of [`Order::Pose`].
        Pose = b'P',
        /// Letter of [`Order::Scan`].
        Scan = b'S',
        /// Letter of [`Order::Activate`].
        Activate = b'A',
        /// [`Order::SetParameter`] and [`Order::ReadParameter`].
        Parameter = b'V',
        /// Letter of [`Order::ReadParameters`].
        Parameters = b'N',
        /// Letter of [`Order::KeepParameters`].
        Keep = b'K',
        /// Letter of [`Order::Unknown`].
        Unknown = b'?',
    }
}

impl Command {
    pub(super) fn write(&self, frame: &mut Frame) {
        frame.push_sixbit(1, u32::from(self.sequence));
        frame.push(self.order.order_type().letter());
        match self.order {
            Order::Mode(mode) => frame.push(mode.letter()),
            Order::Layers { which, allowed } => {
                let (which, allowed) = (which.bits(), allowed.and(which).bits());
                frame.push_sixbit(3, u32::from(which) << 8 | u32::from(allowed));
            }
            Order::Pose {
                position,
                theta_deg,
            } => {
                push_point(frame, position);
                frame.push_sixbit(2, u32::from(theta_deg.min(FIELD_MAX)));
            }
            Order::Failsafe(failsafe) => {
                let silence_s = failsafe.map_or(0, |failsafe| failsafe.silence_s);
                frame.push_sixbit(2, u32::from(silence_s.min(FIELD_MAX)));
                let mode = failsafe.map_or(Mode::Stop, |failsafe| failsafe.mode);
                frame.push(mode.letter());
            }
            Order::Activate { tag, count, digest } => {
                frame.push_sixbit(1, u32::from(tag));
                frame.push_sixbit(2, u32::from(count.min(FIELD_MAX)));
                // Six characters hold 36 bits: the first holds the digest's top two.
                frame.push_sixbit(1, digest >> 30);
                frame.push_sixbit(5, digest);
            }
            Order::SetParameter { key, value } => {
                frame.push_sixbit(4, key);
                frame.push_sixbit(3, value.clamp(VALUE_LEAST, VALUE_MOST) as u32);
            }
            Order::ReadParameter { key } => frame.push_sixbit(4, key),
            Order::ReadParameters { place } => {
                frame.push_sixbit(2, u32::from(place.min(FIELD_MAX)));
            }
            Order::Scan | Order::KeepParameters | Order::Unknown => {}
        }
    }

    pub(super) fn parse(input: &[u8]) -> Parsed<'_, Self> {
        map((number(1), Order::parse), |(sequence, order)| Self {
            sequence: sequence as u8,
            order,
        })
        .parse(input)
    }
}

impl Order {
    /// The type of the order.
    #[must_use]
    pub const fn order_type(&self) -> OrderType {
        match self {
            Self::Mode(_) => OrderType::Mode,
            Self::Layers { .. } => OrderType::Layers,
            Self::Failsafe(_) => OrderType::Failsafe,
            Self::Pose { .. } => OrderType::Pose,
            Self::Scan => OrderType::Scan,
            Self::Activate { .. } => OrderType::Activate,
            Self::SetParameter { .. } | Self::ReadParameter { .. } => OrderType::Parameter,
            Self::ReadParameters { .. } => OrderType::Parameters,
            Self::KeepParameters => OrderType::Keep,
            Self::Unknown => OrderType::Unknown,
        }
    }

    /// The lowest level (SPEC.md section 1) at which robots accept the order.
    #[must_use]
    pub const fn level(&self) -> u8 {
        match self {
            Self::Mode(_) | Self::Layers { .. } | Self::Unknown => 2,
            Self::Activate { .. } => 3,
            Self::Pose { .. } | Self::Scan | Self::Failsafe(_) => 4,
            Self::SetParameter { .. }
            | Self::ReadParameter { .. }
            | Self::ReadParameters { .. }
            | Self::KeepParameters => 5,
        }
    }

    /// Parses any content as an order, because the acknowledgement must refuse an unreadable order.
    fn parse(input: &[u8]) -> Parsed<'_, Self> {
        map(rest, |content| {
            Self::known(content).unwrap_or(Self::Unknown)
        })
        .parse(input)
    }

    fn known(content: &[u8]) -> Option<Self> {
        let (&letter, fields) = content.split_first()?;
        let (left, order) = match OrderType::from_letter(letter)? {
            OrderType::Mode => map(mode, Self::Mode).parse(fields),
            OrderType::Layers => map_opt(number(3), layers).parse(fields),
            OrderType::Failsafe => map_opt((number(2), mode), failsafe).parse(fields),
            OrderType::Pose => {
                let theta = map_opt(number(2), |theta| (theta < 360).then_some(theta as u16));
                let pose = |(position, theta_deg)| Self::Pose {
                    position,
                    theta_deg,
                };
                map((point, theta), pose).parse(fields)
            }
            OrderType::Scan => Ok((fields, Self::Scan)),
            OrderType::Activate => {
                let top = map_opt(number(1), |top| (top < 4).then_some(top));
                let activate = |(tag, count, top, low)| Self::Activate {
                    tag: tag as u8,
                    count: count as u16,
                    digest: top << 30 | low,
                };
                map((number(1), number(2), top, number(5)), activate).parse(fields)
            }
            OrderType::Parameter => map((number(4), opt(number(3))), parameter).parse(fields),
            OrderType::Parameters => {
                let place = |place| Self::ReadParameters {
                    place: place as u16,
                };
                map(number(2), place).parse(fields)
            }
            OrderType::Keep => Ok((fields, Self::KeepParameters)),
            OrderType::Unknown => return None,
        }
        .ok()?;
        left.is_empty().then_some(order)
    }
}

fn mode(input: &[u8]) -> Parsed<'_, Mode> {
    map_opt(take(1_usize), |letter: &[u8]| Mode::from_letter(letter[0])).parse(input)
}

/// Reads `which` and `allowed`; `allowed` must be a subset of `which`.
fn layers(bits: u32) -> Option<Order> {
    let (which, allowed) = (
        LayerMask::from_bits((bits >> 8) as u8),
        LayerMask::from_bits(bits as u8),
    );
    (bits >> 16 == 0 && allowed.and(which) == allowed).then_some(Order::Layers { which, allowed })
}

/// Reads silence and mode; a silence of 0 is valid only with mode stop.
fn failsafe((silence_s, mode): (u32, Mode)) -> Option<Order> {
    match (silence_s as u16, mode) {
        (0, Mode::Stop) => Some(Order::Failsafe(None)),
        (0, _) => None,
        (silence_s, mode) => Some(Order::Failsafe(Some(Failsafe { silence_s, mode }))),
    }
}

/// Reads an order that sets a parameter or, without a value, requests its line P.
fn parameter((key, value): (u32, Option<u32>)) -> Order {
    match value {
        // Shifting up and down again copies the sign to the bits above the 18.
        Some(bits) => Order::SetParameter {
            key,
            value: (bits << 14) as i32 >> 14,
        },
        None => Order::ReadParameter { key },
    }
}

#[cfg(test)]
mod tests {
    use super::super::Message;
    use super::super::testing::read_back;
    use super::*;
    use proptest::prelude::*;

    fn order() -> impl Strategy<Value = Order> {
        prop::sample::select(OrderType::ALL).prop_flat_map(order_of)
    }

    fn order_of(order_type: OrderType) -> BoxedStrategy<Order> {
        let coordinate = || -9999..=9999_i16;
        let mode = || prop::sample::select(Mode::ALL);
        let key = || 0..1_u32 << 24;
        match order_type {
            OrderType::Mode => mode().prop_map(Order::Mode).boxed(),
            OrderType::Layers => any::<(u8, u8)>()
                .prop_map(|(which, allowed)| Order::Layers {
                    which: LayerMask::from_bits(which),
                    allowed: LayerMask::from_bits(allowed & which),
                })
                .boxed(),
            OrderType::Failsafe => {
                let failsafe = (1..4096_u16, mode())
                    .prop_map(|(silence_s, mode)| Failsafe { silence_s, mode });
                prop::option::of(failsafe).prop_map(Order::Failsafe).boxed()
            }
            OrderType::Pose => (coordinate(), coordinate(), 0..360_u16)
                .prop_map(|(x_in, y_in, theta_deg)| Order::Pose {
                    position: Waypoint { x_in, y_in },
                    theta_deg,
                })
                .boxed(),
            OrderType::Scan => Just(Order::Scan).boxed(),
            OrderType::Activate => (0..64_u8, 0..4096_u16, any::<u32>())
                .prop_map(|(tag, count, digest)| Order::Activate { tag, count, digest })
                .boxed(),
            OrderType::Parameter => prop_oneof![
                (key(), VALUE_LEAST..=VALUE_MOST)
                    .prop_map(|(key, value)| Order::SetParameter { key, value }),
                key().prop_map(|key| Order::ReadParameter { key }),
            ]
            .boxed(),
            OrderType::Parameters => (0..4096_u16)
                .prop_map(|place| Order::ReadParameters { place })
                .boxed(),
            OrderType::Keep => Just(Order::KeepParameters).boxed(),
            OrderType::Unknown => Just(Order::Unknown).boxed(),
        }
    }

    proptest! {
        #[test]
        fn commands_survive_a_round_trip(sequence in 0..64_u8, order in order()) {
            let command = Message::Command(Command { sequence, order });
            prop_assert_eq!(read_back(command), Some(command));
        }

        #[test]
        fn values_that_do_not_fit_never_change_their_meaning(
            x_in: i16, y_in: i16, theta_deg: u16, count: u16, value: i32, place: u16,
        ) {
            let pose = Order::Pose { position: Waypoint { x_in, y_in }, theta_deg };
            let fits = Waypoint::new(x_in, y_in).is_some() && theta_deg < 360;
            let said = if fits { pose } else { Order::Unknown };
            let read = |order| read_back(Message::Command(Command { sequence: 1, order }));
            prop_assert_eq!(read(pose), Some(Message::Command(Command { sequence: 1, order: said })));
            let activate = |count| Order::Activate { tag: 1, count, digest: 0 };
            let said = Order::Activate { tag: 1, count: count.min(4095), digest: 0 };
            prop_assert_eq!(
                read(activate(count)),
                Some(Message::Command(Command { sequence: 1, order: said }))
            );
            let clamped = value.clamp(VALUE_LEAST, VALUE_MOST);
            for (order, said) in [
                (
                    Order::SetParameter { key: 7, value },
                    Order::SetParameter { key: 7, value: clamped },
                ),
                (
                    Order::ReadParameters { place },
                    Order::ReadParameters { place: place.min(4095) },
                ),
            ] {
                let said = Message::Command(Command { sequence: 1, order: said });
                prop_assert_eq!(read(order), Some(said));
            }
        }
    }

    /// Clamped values are beyond every limit of a parameter.
    const _: () = assert!(
        VALUE_LEAST < -crate::parameter::VALUE_MAX && crate::parameter::VALUE_MAX < VALUE_MOST
    );

    #[test]
    fn unreadable_orders_are_still_commands() {
        for content in [
            &b"C!"[..],
            b"C!?",
            b"C!Mp",
            b"C!M",
            b"C!MPP",
            b"C!L$`",
            b"C!L!",
            b"C!SS",
            b"C!P````````",
            b"C!A!`!$`````",
            b"C!A!`!``````\xFF",
            b"C!V",
            b"C!V```",
            b"C!V`````",
            b"C!V````````",
            b"C!Vaaaa",
            b"C!N!",
            b"C!N!!!",
            b"C!K!",
        ] {
            let expected = Command {
                sequence: 1,
                order: Order::Unknown,
            };
            let shown = content.escape_ascii();
            assert_eq!(
                Message::parse(content),
                Some(Message::Command(expected)),
                "{shown}"
            );
        }
        assert_eq!(Message::parse(b"C S"), None, "a space is no sequence");
    }
}

//! Messages that follow from an event of the station.

use foxglove::messages::log::Level;

use super::{Deriver, Lines};
use crate::event::{
    AlarmStatus, CommandStatus, Level as NoticeLevel, LinkEvent, Mark, Moment, Reception,
};
use crate::messages::{StationEvent, StationEventKind, UplinkEvent};
use crate::topics::{Topic, TopicMessage, ground};
use crate::words::outcome_words;

/// Maximum number of open commands whose text is kept; the oldest are dropped.
const COMMANDS_MAX: usize = 64;

/// A command that has not ended.
#[derive(Debug)]
pub(super) struct Command {
    id: u32,
    words: String,
    waypoints_in: Option<Vec<(i32, i32)>>,
}

impl Deriver {
    /// Takes an event of the station.
    ///
    /// # Errors
    /// The errors of `take`.
    pub fn handle_event<E>(
        &mut self,
        at_ns: u64,
        event: &StationEvent,
        mut take: impl FnMut(TopicMessage<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        self.now_ns = self.now_ns.max(at_ns);
        self.encoder.encode(event);
        take(self.encoder.message(Topic::Station, self.now_ns, None))?;
        if event.is_loss_of_link() {
            self.decoder.interrupt();
            self.own.interrupt();
        }
        if self.lines != Lines::Decoded {
            self.outages
                .handle_event(Moment::from_nanos(self.now_ns), event);
            self.give_outages(&mut take)?;
        }
        let (name, level, text) = match &event.kind {
            Some(StationEventKind::Command(event)) => return self.handle_uplink(event, &mut take),
            Some(StationEventKind::Link(link)) => match link.event() {
                Some(LinkEvent::Opened { name, .. }) => {
                    self.own.reopen();
                    ("link", Level::Info, format!("{name} is open"))
                }
                Some(LinkEvent::Lost { reason }) => {
                    ("link", Level::Warning, format!("link lost: {reason}"))
                }
                Some(LinkEvent::Ended) => ("link", Level::Info, "the link has ended".to_owned()),
                None => return Ok(()),
            },
            Some(StationEventKind::Reception(code)) => {
                let Some(reception) = Reception::from_code(code) else {
                    return Ok(());
                };
                let (level, text) = reception_words(reception);
                ("link", level, text.to_owned())
            }
            Some(StationEventKind::Mark(mark)) => {
                ("mark", Level::Info, Mark::from(*mark).to_string())
            }
            Some(StationEventKind::Notice(notice)) => {
                let level = match notice.level() {
                    NoticeLevel::Info => Level::Info,
                    NoticeLevel::Warning => Level::Warning,
                    NoticeLevel::Alarm => Level::Error,
                };
                ("station", level, notice.text.clone())
            }
            Some(StationEventKind::Suspension(it)) => {
                let duration_s = Moment::from_nanos(it.duration_ns).as_secs_f64();
                let text = format!("the station was suspended for {duration_s:.1} s");
                ("station", Level::Warning, text)
            }
            Some(StationEventKind::Alarm(alarm)) => {
                match alarm.event(Moment::from_nanos(self.now_ns)) {
                    Some(alarm) => {
                        let level = match (alarm.status, alarm.level) {
                            (AlarmStatus::Begun, NoticeLevel::Alarm) => Level::Error,
                            (AlarmStatus::Begun, NoticeLevel::Warning) => Level::Warning,
                            _ => Level::Info,
                        };
                        ("alarm", level, alarm.to_string())
                    }
                    None => return Ok(()),
                }
            }
            Some(StationEventKind::Suggestion(suggestion)) => match suggestion.event() {
                Some(suggestion) => ("suggestion", Level::Info, suggestion.to_string()),
                None => return Ok(()),
            },
            Some(StationEventKind::Estimate(estimate)) => {
                let Some((pose, transforms)) = ground::corrected(self.now_ns, estimate) else {
                    let text = "the ground does not know the robot's heading";
                    self.encoder
                        .log(self.now_ns, Level::Warning, "ground", text);
                    return take(self.encoder.message(Topic::Log, self.now_ns, None));
                };
                self.encoder.encode(&pose);
                take(
                    self.encoder
                        .message(Topic::PoseCorrected, self.now_ns, None),
                )?;
                self.encoder.encode(&transforms);
                return take(self.encoder.message(Topic::TfMap, self.now_ns, None));
            }
            Some(StationEventKind::Floor(floor)) => {
                let Some(grid) = ground::grid(self.now_ns, floor) else {
                    return Ok(());
                };
                self.encoder.encode(&grid);
                return take(self.encoder.message(Topic::Map, self.now_ns, None));
            }
            None => return Ok(()),
        };
        self.encoder.log(self.now_ns, level, name, &text);
        take(self.encoder.message(Topic::Log, self.now_ns, None))
    }

    fn handle_uplink<E>(
        &mut self,
        event: &UplinkEvent,
        take: &mut impl FnMut(TopicMessage<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        self.encoder.encode(event);
        take(self.encoder.message(Topic::Uplink, self.now_ns, None))?;
        let (Some(id), Some(status)) = (event.command_id, event.command_status()) else {
            return Ok(());
        };
        if status == CommandStatus::Queued {
            if self.commands.len() == COMMANDS_MAX {
                self.commands.pop_front();
            }
            let points = event.waypoints_x_in.iter().zip(&event.waypoints_y_in);
            self.commands.push_back(Command {
                id,
                words: event.command.clone().unwrap_or_default(),
                waypoints_in: event.total.map(|_| points.map(|(&x, &y)| (x, y)).collect()),
            });
            return Ok(());
        }
        if !status.is_end() {
            return Ok(());
        }
        let ended = self.commands.iter().position(|command| command.id == id);
        let Some(command) = ended.and_then(|at| self.commands.remove(at)) else {
            return Ok(());
        };
        let (level, end) = match status {
            CommandStatus::Refused(outcome) => (
                Level::Warning,
                format!("refused: {}", outcome_words(outcome)),
            ),
            CommandStatus::Failed(failure) => (Level::Warning, failure.to_string()),
            CommandStatus::Echoed => (Level::Info, "echoed".to_owned()),
            _ => (Level::Info, "confirmed".to_owned()),
        };
        let text = format!("{}: {end}", command.words);
        self.encoder.log(self.now_ns, level, "command", &text);
        take(self.encoder.message(Topic::Log, self.now_ns, None))?;
        if let CommandStatus::Confirmed { .. } = status
            && let Some(waypoints_in) = command.waypoints_in
        {
            self.scene.set_waypoints(waypoints_in.into_iter());
            self.give_scene(None, take)?;
        }
        Ok(())
    }
}

const fn reception_words(reception: Reception) -> (Level, &'static str) {
    match reception {
        Reception::Lines => (Level::Info, "intact lines arrive"),
        Reception::Nothing => (Level::Warning, "no bytes arrive"),
        Reception::Noise => (Level::Warning, "only noise arrives"),
        Reception::Damaged => (Level::Warning, "no line arrives intact"),
        Reception::WrongRate(_) => (Level::Warning, "the radio has another baud rate"),
    }
}

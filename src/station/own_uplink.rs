//! Delivers command strings to a robot without acknowledgements: sent as text, echoed by a reply, never confirmed.

use std::collections::{BTreeMap, VecDeque};

use groundwave_lines::OwnCommand;

use crate::event::{CommandId, CommandStatus, Failure, Moment};
use crate::request::Request;

/// Maximum time to wait for the reply to a command.
const PATIENCE: Moment = Moment::from_secs(5);

/// Interval of the repetitions of STOP; other commands are sent once.
const STOP_INTERVAL: Moment = Moment::from_millis(500);

/// Maximum number of commands that wait for a reply; further commands fail.
const WAITING_MAX: usize = 16;

/// A command that waits for its reply.
#[derive(Clone, Debug)]
struct Waiting {
    id: CommandId,
    bytes: Vec<u8>,
    reply: String,
    is_stop: bool,
    frames: u32,
    /// Time at which the command is sent again; `None` for a command that is sent once.
    again_at: Option<Moment>,
    over_at: Moment,
}

/// The command strings of a robot.
#[derive(Clone, Debug, Default)]
pub(super) struct OwnUplink {
    commands: BTreeMap<String, OwnCommand>,
    waiting: VecDeque<Waiting>,
    outgoing: VecDeque<Vec<u8>>,
    statuses: VecDeque<(CommandId, CommandStatus)>,
    /// Whether the link is lost; STOP waits for it as long as it would wait for a reply.
    is_lost: bool,
}

impl OwnUplink {
    pub(super) fn new(commands: BTreeMap<String, OwnCommand>) -> Self {
        Self {
            commands,
            ..Self::default()
        }
    }

    pub(super) const fn set_lost(&mut self, is_lost: bool) {
        self.is_lost = is_lost;
    }

    /// Sends a request; STOP ends all others.
    pub(super) fn handle_request(&mut self, now: Moment, id: CommandId, request: &Request) {
        let is_stop = *request == Request::Stop;
        if is_stop {
            self.outgoing.clear();
            self.end_all(Failure::Stopped, |waiting| !waiting.is_stop);
        }
        let words = request.to_string();
        let words: Vec<&str> = words.split(' ').collect();
        let filled = words.split_first().and_then(|(name, arguments)| {
            let command = self.commands.get(*name)?;
            command.with(arguments).ok()
        });
        if self.is_lost && !is_stop {
            let not_sent = CommandStatus::Failed(Failure::NotSent);
            self.statuses.push_back((id, not_sent));
            return;
        }
        let Some((bytes, reply)) = filled.filter(|_| self.waiting.len() < WAITING_MAX) else {
            let failed = CommandStatus::Failed(Failure::NotConfigured);
            self.statuses.push_back((id, failed));
            return;
        };
        self.waiting.push_back(Waiting {
            id,
            bytes,
            reply,
            is_stop,
            frames: 0,
            again_at: Some(now),
            over_at: now + PATIENCE,
        });
        self.handle_timeout(now);
    }

    /// Takes a line of the robot; it is the echo of the oldest command with this reply.
    pub(super) fn handle_line(&mut self, text: &str) {
        let text = text.trim();
        let echoed = self
            .waiting
            .iter()
            .position(|it| text.starts_with(&it.reply));
        if let Some(waiting) = echoed.and_then(|at| self.waiting.remove(at)) {
            self.statuses.push_back((waiting.id, CommandStatus::Echoed));
        }
    }

    pub(super) fn handle_timeout(&mut self, now: Moment) {
        let due = self.waiting.iter_mut().filter(|_| !self.is_lost);
        for waiting in due {
            if waiting.again_at.is_some_and(|at| at <= now) {
                waiting.frames += 1;
                waiting.again_at = waiting.is_stop.then_some(now + STOP_INTERVAL);
                self.outgoing.push_back(waiting.bytes.clone());
                let sent = CommandStatus::Sent {
                    frames: waiting.frames,
                };
                self.statuses.push_back((waiting.id, sent));
            }
        }
        self.end_all(Failure::NotSent, |waiting| {
            waiting.over_at <= now && waiting.frames == 0
        });
        self.end_all(Failure::TimedOut, |waiting| waiting.over_at <= now);
    }

    /// Ends the command with number `id`, or all commands.
    pub(super) fn cancel(&mut self, why: Failure, id: Option<CommandId>) {
        self.end_all(why, |waiting| id.is_none_or(|id| waiting.id == id));
    }

    fn end_all(&mut self, why: Failure, ends: impl Fn(&Waiting) -> bool) {
        let ended = self.waiting.iter().filter(|waiting| ends(waiting));
        let ended = ended.map(|waiting| (waiting.id, CommandStatus::Failed(why)));
        self.statuses.extend(ended.collect::<Vec<_>>());
        self.waiting.retain(|waiting| !ends(waiting));
    }

    pub(super) fn poll_status(&mut self) -> Option<(CommandId, CommandStatus)> {
        self.statuses.pop_front()
    }

    pub(super) fn poll_transmit(&mut self) -> Option<Vec<u8>> {
        self.outgoing.pop_front()
    }

    pub(super) fn poll_timeout(&self) -> Option<Moment> {
        let again = |it: &Waiting| it.again_at.filter(|_| !self.is_lost);
        let deadlines = self.waiting.iter();
        let deadlines = deadlines.flat_map(|it| [Some(it.over_at), again(it)]);
        deadlines.flatten().min()
    }

    pub(super) fn is_settled(&self) -> bool {
        self.waiting.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn uplink() -> OwnUplink {
        let command = |send: &str, reply: &str| OwnCommand {
            send: send.to_owned(),
            reply: reply.to_owned(),
        };
        OwnUplink::new(BTreeMap::from([
            ("stop".to_owned(), command("S\n", "OK S")),
            ("goto".to_owned(), command("G {x} {y}\n", "OK G")),
        ]))
    }

    fn drained(uplink: &mut OwnUplink) -> (Vec<String>, Vec<(u32, CommandStatus)>) {
        let sent = std::iter::from_fn(|| uplink.poll_transmit());
        let sent = sent
            .map(|bytes| String::from_utf8(bytes).expect("text"))
            .collect();
        let statuses = std::iter::from_fn(|| uplink.poll_status());
        (sent, statuses.map(|(id, status)| (id.0, status)).collect())
    }

    #[test]
    fn a_reply_echoes_a_command_and_nothing_confirms_it() {
        let mut uplink = uplink();
        let goto = Request::Own("goto 48 -3".to_owned());
        uplink.handle_request(Moment::ZERO, CommandId(1), &goto);
        let sent = CommandStatus::Sent { frames: 1 };
        assert_eq!(
            drained(&mut uplink),
            (vec!["G 48 -3\n".to_owned()], vec![(1, sent)])
        );
        uplink.handle_line("temp:21.5");
        assert_eq!(drained(&mut uplink).1, []);
        uplink.handle_line("OK G 48 -3\r");
        assert_eq!(drained(&mut uplink).1, [(1, CommandStatus::Echoed)]);
        uplink.handle_line("OK G");
        assert_eq!(drained(&mut uplink).1, []);
        assert!(uplink.is_settled());
    }

    #[test]
    fn stop_is_repeated_until_its_echo_and_ends_the_others() {
        let mut uplink = uplink();
        uplink.handle_request(
            Moment::ZERO,
            CommandId(1),
            &Request::Own("goto 1 2".to_owned()),
        );
        drained(&mut uplink);
        uplink.handle_request(Moment::ZERO, CommandId(2), &Request::Stop);
        let (sent, statuses) = drained(&mut uplink);
        assert_eq!(sent, ["S\n"]);
        assert_eq!(statuses[0], (1, CommandStatus::Failed(Failure::Stopped)));
        let again_at = uplink.poll_timeout().expect("it is repeated");
        uplink.handle_timeout(again_at);
        assert_eq!(drained(&mut uplink).0, ["S\n"]);
        uplink.handle_timeout(PATIENCE);
        let timed_out = CommandStatus::Failed(Failure::TimedOut);
        assert_eq!(drained(&mut uplink).1.last(), Some(&(2, timed_out)));
        assert_eq!(uplink.poll_timeout(), None);
    }

    #[test]
    fn only_stop_waits_for_a_lost_link() {
        let mut uplink = uplink();
        uplink.set_lost(true);
        let goto = Request::Own("goto 48 -3".to_owned());
        let not_sent = CommandStatus::Failed(Failure::NotSent);
        uplink.handle_request(Moment::ZERO, CommandId(0), &goto);
        assert_eq!(drained(&mut uplink), (vec![], vec![(0, not_sent)]));
        uplink.handle_request(Moment::ZERO, CommandId(1), &Request::Stop);
        assert_eq!(drained(&mut uplink), (vec![], vec![]));
        assert_eq!(uplink.poll_timeout(), Some(PATIENCE));
        uplink.handle_timeout(PATIENCE);
        assert_eq!(drained(&mut uplink), (vec![], vec![(1, not_sent)]));

        uplink.handle_request(PATIENCE, CommandId(2), &Request::Stop);
        uplink.set_lost(false);
        assert_eq!(uplink.poll_timeout(), Some(PATIENCE));
        uplink.handle_timeout(PATIENCE);
        let sent = CommandStatus::Sent { frames: 1 };
        let expected = (vec!["S\n".to_owned()], vec![(2, sent)]);
        assert_eq!(drained(&mut uplink), expected);
    }

    #[test]
    fn commands_without_a_string_fail_at_once() {
        let mut uplink = uplink();
        for words in ["scan", "goto 1"] {
            let request = Request::Own(words.to_owned());
            uplink.handle_request(Moment::ZERO, CommandId(1), &request);
            let failed = CommandStatus::Failed(Failure::NotConfigured);
            assert_eq!(drained(&mut uplink), (vec![], vec![(1, failed)]));
        }
    }
}

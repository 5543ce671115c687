//! News for the hint line: command steps, log lines and feedback to keys.

use super::{Shown, Ui, ledger, log};
use crate::event::Moment;

/// The newest news.
#[derive(Clone, Copy, Debug)]
pub(crate) enum News<'a> {
    /// A command's latest step.
    Command(&'a ledger::Entry),
    /// A log line of the station, or an alarm of the robot.
    Logged(&'a log::Entry),
    /// Feedback to a key.
    Passing(&'a Passing),
}

/// Feedback to a key that is not logged.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Passing {
    /// The list of panels, after the operator chose another panel.
    Panels,
    /// A text.
    Words(String),
}

/// Time for which news is shown.
const NEWS_FOR: Moment = Moment::from_secs(5);

/// Time for which feedback to a key is shown whatever happens meanwhile, such as the lines of a list.
const FEEDBACK_FOR: Moment = Moment::from_secs(2);

impl Ui {
    /// Shows feedback to a key.
    pub(super) fn pass_on(&mut self, now: Moment, what: Passing) {
        self.passing = Some((now, what));
    }
}

impl<'a> Shown<'a> {
    /// The news at `now`.
    pub(crate) fn news(&self, now: Moment) -> Option<News<'a>> {
        let (at, news) = self.newest(now)?;
        (now < at + NEWS_FOR).then_some(news)
    }

    /// Time at which the news expires.
    pub(super) fn news_until(&self, now: Moment) -> Option<Moment> {
        let feedback = self.ui.passing.as_ref().map(|(at, _)| *at + FEEDBACK_FOR);
        let newest = self.newest(now).map(|(at, _)| at + NEWS_FOR);
        let ends = feedback.into_iter().chain(newest);
        ends.filter(|until| *until > now).min()
    }

    fn newest(&self, now: Moment) -> Option<(Moment, News<'a>)> {
        let command = self.facts.ledger.newest();
        let command = command.map(|entry| (entry.at, News::Command(entry)));
        let logged = self.facts.log.newest_first().find(|entry| entry.is_news());
        let logged = logged.map(|entry| (entry.at, News::Logged(entry)));
        let passing = self.ui.passing.as_ref();
        let passing = passing.map(|(at, what)| (*at, News::Passing(what)));
        if let Some((at, _)) = passing
            && now < at + FEEDBACK_FOR
        {
            return passing;
        }
        // The newest news is shown: a log line after a command replaces it.
        command
            .into_iter()
            .chain(logged)
            .chain(passing)
            .max_by_key(|(at, _)| *at)
    }
}

//! What the documents of all measurements begin with.

use raxel_measure::light::DeviceName;
use serde_json::{Value, json};

/// The machine and the command of a measurement.
pub(super) struct About {
    pub device: DeviceName,
    pub command: String,
    pub date: String,
}

impl About {
    /// A measurement by this process, today.
    pub(crate) fn of(device: DeviceName) -> Self {
        Self { device, command: command(std::env::args().skip(1)), date: today() }
    }

    pub(crate) fn json(&self, reason: &str) -> Value {
        json!({
            "reason": reason,
            "device": self.device.name,
            "driver": self.device.driver,
            "raxel": env!("CARGO_PKG_VERSION"),
            "command": self.command,
            "date": self.date,
        })
    }
}

/// The command that measures the same, without where it writes: that is of no use elsewhere.
pub(super) fn command(mut arguments: impl Iterator<Item = String>) -> String {
    let mut command = "raxel".to_owned();
    while let Some(argument) = arguments.next() {
        if argument == "-o" || argument == "--output" {
            arguments.next();
        } else if !argument.starts_with("-o") && !argument.starts_with("--output=") {
            command.push(' ');
            command.push_str(&argument);
        }
    }
    command
}

/// Today, as year-month-day.
pub(super) fn today() -> String {
    jiff::Timestamp::now().strftime("%F").to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_say_nothing_of_outputs() {
        let arguments = "bench dda -o some/folder --size 8x8 --output=there -oelsewhere --frames 3";
        assert_eq!(command(arguments.split(' ').map(str::to_owned)), "raxel bench dda --size 8x8 --frames 3");
    }
}

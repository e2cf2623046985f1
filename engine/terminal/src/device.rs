//! The meaning of errors of the driver and the device for the command line.

use raxel_execute::ExecuteError;
use raxel_gpu::Error;
use raxel_runtime::present::PresentError;

use crate::failure::{Exit, Failure};

impl From<&Error> for Failure {
    fn from(error: &Error) -> Self {
        let exit = match error {
            Error::DeviceLost | Error::TimedOut { .. } => Exit::DeviceLost,
            _ => Exit::NoDevice,
        };
        // The advice stands on lines of its own.
        let text = error.to_string();
        let (advice, message): (Vec<&str>, Vec<&str>) = text.lines().partition(|line| line.starts_with("help: "));
        let failure = Failure::new(exit, message.join("\n"));
        let failure = match error {
            Error::NotMade { .. } => failure.help(
                "a newer driver may make it; `raxel doctor` lists the devices, and `--device` chooses another one",
            ),
            _ => failure,
        };
        advice.into_iter().fold(failure, |failure, line| failure.help(line.trim_start_matches("help: ")))
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        Self::from(&error)
    }
}

impl From<ExecuteError> for Failure {
    fn from(error: ExecuteError) -> Self {
        match error {
            ExecuteError::Gpu(error) => error.into(),
            ExecuteError::DeviceLost { timed_out, ref suspect } => {
                let mut failure = Failure::new(Exit::DeviceLost, error.to_string());
                if suspect.is_some() {
                    failure =
                        failure.help("a loop in the pass named above may not end, or run too long for the driver");
                }
                if timed_out {
                    failure.help("a slow or busy machine may need more time: `--watchdog SECONDS` gives it")
                } else {
                    failure
                }
            }
            ExecuteError::Format { .. } | ExecuteError::Capability { .. } => {
                Failure::new(Exit::NoDevice, error.to_string())
            }
            ExecuteError::NoFrame { .. }
            | ExecuteError::NotLive { .. }
            | ExecuteError::NotKept { .. }
            | ExecuteError::CulledWriter { .. }
            | ExecuteError::OutOfRange { .. } => Failure::usage(error.to_string()),
            ExecuteError::MissingSource { .. } | ExecuteError::NoPlan | ExecuteError::Display(_) => {
                Failure::new(Exit::Project, error.to_string())
            }
        }
    }
}

impl From<PresentError> for Failure {
    fn from(error: PresentError) -> Self {
        match error {
            PresentError::Gpu(error) => error.into(),
            error @ PresentError::Shader(_) => Failure::new(Exit::NoDevice, error.to_string()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missing_driver_is_exit_code_4_with_the_command_that_installs_one() {
        let failure = Failure::from(Error::NoDriver { candidates: Vec::new() });
        assert_eq!(failure.exit, Exit::NoDevice);
        assert!(failure.help.last().is_some_and(|help| help.contains("apt-get install")), "{failure:?}");
        assert!(!failure.message.unwrap().contains("help"));
        assert_eq!(Failure::from(Error::DeviceLost).exit, Exit::DeviceLost);
    }

    #[test]
    fn a_loss_without_a_suspect_blames_no_pass() {
        let lost = ExecuteError::DeviceLost { suspect: None, timed_out: false };
        assert_eq!(Failure::from(lost).help, Vec::<String>::new());
    }
}

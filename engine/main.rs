//! The `raxel` binary.

fn main() -> std::process::ExitCode {
    raxel_app::main()
}

// Starts `raxel lsp` for the files of raxel projects, and runs `raxel check` and `raxel run` as tasks.
"use strict";

const path = require("path");
const vscode = require("vscode");
const { LanguageClient } = require("vscode-languageclient/node");

let client;

// The program of the setting `raxel.path`. A relative file is one of the first folder of the workspace.
function program() {
    const set = vscode.workspace.getConfiguration("raxel").get("path") || "raxel";
    const folder = vscode.workspace.workspaceFolders?.[0]?.uri.fsPath;
    return folder && /[\\/]/.test(set) && !path.isAbsolute(set) ? path.join(folder, set) : set;
}

async function start() {
    const run = { command: program(), args: ["lsp"] };
    const options = {
        documentSelector: [
            { scheme: "file", language: "toml" },
            { scheme: "file", language: "glsl" },
        ],
        outputChannelName: "raxel",
    };
    client = new LanguageClient("raxel", "raxel", { run, debug: run }, options);
    try {
        await client.start();
    } catch (error) {
        const settings = "Open the setting";
        const text = `raxel: \`${run.command} lsp\` does not start (${error.message}). Set \`raxel.path\` to the program raxel.`;
        // Nobody waits for the answer.
        vscode.window.showErrorMessage(text, settings).then((answer) => {
            if (answer === settings) vscode.commands.executeCommand("workbench.action.openSettings", "raxel.path");
        });
    }
}

async function stop() {
    const old = client;
    client = undefined;
    if (old?.needsStop?.()) await old.stop();
}

// A task that runs a verb, on a file where one is named.
function task(folder, verb, file) {
    const words = verb === "check" ? ["check", "--format", "short"] : [verb];
    const execution = new vscode.ProcessExecution(program(), file ? [...words, file] : words, { cwd: folder.uri.fsPath });
    const definition = file ? { type: "raxel", verb, file } : { type: "raxel", verb };
    const made = new vscode.Task(definition, folder, file ? `${verb} ${file}` : verb, "raxel", execution, ["$raxel"]);
    if (verb === "check") made.group = vscode.TaskGroup.Build;
    return made;
}

const tasks = {
    provideTasks: () => (vscode.workspace.workspaceFolders ?? []).flatMap((folder) => ["check", "run"].map((verb) => task(folder, verb))),
    resolveTask: ({ definition, scope }) => (scope?.uri ? task(scope, definition.verb, definition.file) : undefined),
};

// Runs a verb in the folder of the open file, or in the first one.
function execute(verb, file) {
    const folder = (file && vscode.workspace.getWorkspaceFolder(file)) ?? vscode.workspace.workspaceFolders?.[0];
    if (!folder) return vscode.window.showErrorMessage("raxel: open the folder of a project first.");
    return vscode.tasks.executeTask(task(folder, verb, file && path.relative(folder.uri.fsPath, file.fsPath)));
}

async function activate(context) {
    context.subscriptions.push(
        vscode.commands.registerCommand("raxel.check", () => execute("check")),
        vscode.commands.registerCommand("raxel.run", () => {
            const open = vscode.window.activeTextEditor?.document;
            return execute("run", open?.languageId === "toml" && path.basename(open.fileName) !== "raxel.toml" ? open.uri : undefined);
        }),
        vscode.commands.registerCommand("raxel.restart", async () => {
            await stop();
            await start();
        }),
        vscode.tasks.registerTaskProvider("raxel", tasks),
        vscode.workspace.onDidChangeConfiguration(async (change) => {
            if (!change.affectsConfiguration("raxel.path")) return;
            await stop();
            await start();
        }),
    );
    await start();
}

module.exports = { activate, deactivate: stop };

// The extension without VS Code: its manifest and its code agree, and the server that it asks for answers.
// `RAXEL` names the program; without it, `raxel` on the path is taken.
"use strict";

const assert = require("node:assert");
const { spawn } = require("node:child_process");
const fs = require("node:fs");
const Module = require("node:module");
const path = require("node:path");
const { test } = require("node:test");
const { pathToFileURL } = require("node:url");

const root = path.join(__dirname, "..");
const manifest = JSON.parse(fs.readFileSync(path.join(root, "package.json"), "utf8"));

// What stands for VS Code: it remembers what the extension has asked of it.
function editor({ raxelPath = "raxel", folder, fails }) {
    const asked = { commands: {}, clients: [], tasks: [], errors: [], providers: {} };
    const folders = folder ? [{ uri: { fsPath: folder } }] : undefined;
    const vscode = {
        workspace: {
            workspaceFolders: folders,
            getConfiguration: () => ({ get: (key) => ({ path: raxelPath })[key] }),
            getWorkspaceFolder: (uri) => folders?.find((f) => uri.fsPath.startsWith(f.uri.fsPath)),
            onDidChangeConfiguration: (then) => ((asked.changed = then), { dispose() {} }),
        },
        window: { showErrorMessage: async (text) => void asked.errors.push(text) },
        commands: { registerCommand: (name, run) => ((asked.commands[name] = run), { dispose() {} }) },
        tasks: {
            registerTaskProvider: (type, provider) => ((asked.providers[type] = provider), { dispose() {} }),
            executeTask: (task) => asked.tasks.push(task),
        },
        ProcessExecution: class { constructor(program, words, options) { Object.assign(this, { program, words, options }); } },
        Task: class { constructor(definition, scope, name, source, execution, matchers) { Object.assign(this, { definition, scope, name, source, execution, matchers }); } },
        TaskGroup: { Build: "build" },
    };
    class LanguageClient {
        constructor(id, name, server, options) { Object.assign(this, { id, server, options, running: false }); asked.clients.push(this); }
        async start() { if (fails) throw new Error("no such program"); this.running = true; }
        needsStop() { return this.running; }
        async stop() { this.running = false; }
    }
    const modules = { vscode, "vscode-languageclient/node": { LanguageClient } };
    const load = Module._load;
    Module._load = (name, ...rest) => modules[name] ?? load(name, ...rest);
    try {
        delete require.cache[require.resolve("../extension.js")];
        return { asked, vscode, extension: require("../extension.js") };
    } finally {
        Module._load = load;
    }
}

async function activated(options) {
    const made = editor(options);
    await made.extension.activate({ subscriptions: [] });
    return made;
}

test("every command of the manifest is registered, and no other", async () => {
    const { asked } = await activated({});
    assert.deepEqual(Object.keys(asked.commands).sort(), manifest.contributes.commands.map(({ command }) => command).sort());
    assert.deepEqual(Object.keys(asked.providers), manifest.contributes.taskDefinitions.map(({ type }) => type));
    for (const { configuration } of manifest.contributes.languages) assert(!configuration || fs.existsSync(path.join(root, configuration)));
    assert(fs.existsSync(path.join(root, manifest.main)));
});

test("the server is the program of the setting, for TOML and GLSL", async () => {
    const { asked } = await activated({ raxelPath: "target/release/raxel", folder: "/project" });
    const [client] = asked.clients;
    assert.deepEqual(client.server.run, { command: path.join("/project", "target/release/raxel"), args: ["lsp"] });
    assert.deepEqual(client.options.documentSelector.map(({ language }) => language), ["toml", "glsl"]);
    assert.equal((await activated({ folder: "/project" })).asked.clients[0].server.run.command, "raxel");
    assert.equal((await activated({ raxelPath: "/opt/raxel", folder: "/project" })).asked.clients[0].server.run.command, "/opt/raxel");
});

test("a new path and a restart start another server, and stop the old one", async () => {
    const { asked, extension } = await activated({});
    await asked.changed({ affectsConfiguration: (key) => key === "editor.fontSize" });
    assert.equal(asked.clients.length, 1);
    await asked.changed({ affectsConfiguration: (key) => key === "raxel.path" });
    await asked.commands["raxel.restart"]();
    assert.deepEqual(asked.clients.map(({ running }) => running), [false, false, true]);
    await extension.deactivate();
    assert(!asked.clients[2].running);
});

test("a server that does not start is an error with the setting's name", async () => {
    const { asked, extension } = await activated({ raxelPath: "/none/raxel", fails: true });
    assert.match(asked.errors[0], /`\/none\/raxel lsp` does not start \(no such program\).*`raxel\.path`/);
    await extension.deactivate();
});

test("tasks check and run, with the matcher of the manifest", async () => {
    const { asked, vscode } = await activated({ folder: "/project" });
    vscode.window.activeTextEditor = { document: { languageId: "toml", fileName: "/project/graphs/a.toml", uri: { fsPath: "/project/graphs/a.toml" } } };
    asked.commands["raxel.run"]();
    asked.commands["raxel.check"]();
    vscode.window.activeTextEditor = undefined;
    asked.commands["raxel.run"]();
    assert.deepEqual(asked.tasks.map(({ execution }) => execution.words), [["run", path.join("graphs", "a.toml")], ["check", "--format", "short"], ["run"]]);
    assert(asked.tasks.every(({ execution }) => execution.options.cwd === "/project"));
    assert.deepEqual(asked.tasks[1].matchers, ["$" + manifest.contributes.problemMatchers[0].name]);
    const provided = asked.providers.raxel.provideTasks();
    assert.deepEqual(provided.map(({ definition }) => definition.verb), manifest.contributes.taskDefinitions[0].properties.verb.enum);
    // Without a folder there is nothing to check, and that is said.
    const without = await activated({});
    without.asked.commands["raxel.check"]();
    assert.match(without.asked.errors[0], /open the folder of a project/);
});

// A conversation with a server: messages with a head that has their length.
function conversation({ command, args }) {
    const child = spawn(command, args, { stdio: ["pipe", "pipe", "inherit"] });
    let bytes = Buffer.alloc(0);
    const waiting = [];
    child.stdout.on("data", (more) => {
        bytes = Buffer.concat([bytes, more]);
        for (;;) {
            const end = bytes.indexOf("\r\n\r\n");
            if (end < 0) return;
            const length = Number(/Content-Length: (\d+)/.exec(bytes.subarray(0, end))[1]);
            if (bytes.length < end + 4 + length) return;
            const message = JSON.parse(bytes.subarray(end + 4, end + 4 + length));
            bytes = bytes.subarray(end + 4 + length);
            const at = waiting.findIndex(({ wanted }) => wanted(message));
            if (at >= 0) waiting.splice(at, 1)[0].resolve(message);
        }
    });
    return {
        send(message) {
            const body = JSON.stringify({ jsonrpc: "2.0", ...message });
            child.stdin.write(`Content-Length: ${Buffer.byteLength(body)}\r\n\r\n${body}`);
        },
        next: (wanted) => new Promise((resolve) => waiting.push({ wanted, resolve })),
        ended: new Promise((resolve) => child.on("exit", resolve)),
    };
}

test("the server that the extension asks for reports a mistake and ends", { timeout: 120_000 }, async () => {
    const { asked } = await activated({ raxelPath: process.env.RAXEL || "raxel" });
    const server = conversation(asked.clients[0].server.run);
    server.send({ id: 1, method: "initialize", params: { processId: null, rootUri: null, capabilities: {} } });
    const { result } = await server.next(({ id }) => id === 1);
    assert.equal(result.serverInfo.name, "raxel");
    assert(result.capabilities.completionProvider && result.capabilities.hoverProvider && result.capabilities.definitionProvider);
    server.send({ method: "initialized", params: {} });

    const folder = fs.mkdtempSync(path.join(require("node:os").tmpdir(), "raxel-vscode-"));
    fs.mkdirSync(path.join(folder, "graphs"));
    const file = path.join(folder, "graphs", "a.toml");
    const text = "name = 'a'\npresent = 'nothing'\n";
    fs.writeFileSync(file, text);
    const uri = pathToFileURL(file).href;
    const published = server.next(({ method, params }) => method === "textDocument/publishDiagnostics" && params.uri === uri);
    server.send({ method: "textDocument/didOpen", params: { textDocument: { uri, languageId: "toml", version: 1, text } } });
    const { params } = await published;
    assert(params.diagnostics.some(({ message }) => message.includes("nothing")), JSON.stringify(params));

    server.send({ id: 2, method: "shutdown" });
    await server.next(({ id }) => id === 2);
    server.send({ method: "exit" });
    assert.equal(await server.ended, 0);
    fs.rmSync(folder, { recursive: true });
});

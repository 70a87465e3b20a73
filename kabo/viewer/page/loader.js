// Unpacks what the page carries, gives every module a name that others import it by, and starts kabo/main.js.
(async () => {
  const texts = new Map();
  for (const part of document.querySelectorAll("script[data-name]")) {
    texts.set(part.dataset.name, part.textContent);
    part.remove();
  }
  const unpack = async (name) => {
    const bytes = Uint8Array.from(atob(texts.get(name)), (letter) => letter.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Response(stream).arrayBuffer();
  };
  try {
    const names = [...texts.keys()].filter((name) => name.startsWith("module:"));
    const imports = {};
    await Promise.all(names.map(async (name) => {
      const blob = new Blob([await unpack(name)], { type: "text/javascript" });
      imports[name.slice("module:".length)] = URL.createObjectURL(blob);
    }));
    const map = document.createElement("script");
    map.type = "importmap";
    map.textContent = JSON.stringify({ imports });
    document.head.append(map);
    const [content, block] = await Promise.all([unpack("document"), unpack("arrays")]);
    const { start } = await import("kabo/main.js");
    await start(JSON.parse(new TextDecoder().decode(content)), block);
  } catch (error) {
    const waiting = document.getElementById("waiting") ?? document.body.appendChild(document.createElement("p"));
    waiting.textContent = `This page cannot be shown here: ${error.message ?? error}`;
    waiting.className = "failed";
    console.error(error);
  }
})();

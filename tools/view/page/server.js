// What the page asks of the program, and what it is told.

export async function ask(path, body) {
  const options = body === undefined ? {} : { method: 'POST', body: JSON.stringify(body) };
  const answer = await fetch(path, options);
  if (answer.status === 204) return null;
  const told = await answer.json().catch(() => ({ message: `the program answered ${answer.status}` }));
  if (!answer.ok) throw Object.assign(new Error(told.message), { key: told.key });
  return told;
}

// Red, green and blue of every pixel by rows, linear, 1 is display white.
export async function pixels(number) {
  const answer = await fetch(`pixels?picture=${number}`);
  return answer.status === 200 ? new Float32Array(await answer.arrayBuffer()) : null;
}

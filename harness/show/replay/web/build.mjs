// Bundles the script of both pages with three.js into ../assets. The first line has a hash of what it was made
// from, by which a test of the Rust crate finds a bundle that is out of date.
import { createHash } from 'node:crypto';
import { readFileSync, readdirSync, writeFileSync } from 'node:fs';
import { build } from 'esbuild';

const sources = readdirSync('src').filter((f) => f.endsWith('.js')).sort();
const hash = createHash('sha256');
for (const file of sources) hash.update(readFileSync(`src/${file}`));
hash.update(readFileSync('package-lock.json'));
const licence = readFileSync('node_modules/three/LICENSE', 'utf8').trim();
// What comes with three.js of others has its own head.
const inflate = readFileSync('node_modules/three/examples/jsm/libs/fflate.module.js', 'utf8').match(/^\/\*!\n([^]*?)\*\//)[1].trim();

const result = await build({
  entryPoints: ['src/index.js'],
  bundle: true,
  minify: true,
  write: false,
  format: 'iife',
  target: ['es2022'],
  legalComments: 'none',
});
// No end of a script element in the text.
const text = result.outputFiles[0].text.replaceAll('</script', '<\\/script').replaceAll('<!--', '<\\!--');
const head = `/* sources ${hash.digest('hex')} */\n/*! three.js\n${licence}\n\n${inflate}\n*/\n`;
writeFileSync('../assets/replay.min.js', head + text);

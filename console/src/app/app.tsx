// The frame of all pages: where one is, where one can go, whether the router is there, and STOP.

import type { ComponentType } from 'preact';
import { useEffect } from 'preact/hooks';
import { LayoutMenu } from '../layouts/layout_menu';
import { FleetPage } from '../pages/fleet_page';
import { Boundary } from '../ui/boundary';
import { ConnectionBadge, ConnectionNotice, ExposedNotice } from '../ui/connection';
import { Icon, type IconName } from '../ui/icons';
import { LoginBadge } from '../ui/login';
import { StopButton } from '../ui/stop_button';
import { ThemeSwitch } from '../ui/theme';
import { Keys } from './keys';
import { lazy } from './lazy';
import { Palette } from './palette';
import { go, parseRoute, route } from './route';

const MapPage = lazy(() => import('./pages').then((pages) => pages.MapPage));
const DrivePage = lazy(() => import('./pages').then((pages) => pages.DrivePage));
const MessagesPage = lazy(() => import('./pages').then((pages) => pages.MessagesPage));
const PlotsPage = lazy(() => import('./pages').then((pages) => pages.PlotsPage));
const NetworkPage = lazy(() => import('./pages').then((pages) => pages.NetworkPage));
const RecorderPage = lazy(() => import('./pages').then((pages) => pages.RecorderPage));
const SimulationPage = lazy(() => import('./pages').then((pages) => pages.SimulationPage));
const StudioPage = lazy(() => import('../studio/studio_page').then((pages) => pages.StudioPage));
const ChangeWatch = lazy(() => import('../studio/change_watch').then((watch) => watch.ChangeWatch), true);
const RobotPage = lazy(() => import('./pages').then((pages) => pages.RobotPage));

interface Page {
  name: string;
  title: string;
  icon: IconName;
  view: ComponentType;
  key: string;
}

const pages: Page[] = [
  { name: 'fleet', title: 'Fleet', icon: 'robots', view: FleetPage, key: 'f' },
  { name: 'map', title: 'Map', icon: 'map', view: MapPage, key: 'm' },
  { name: 'drive', title: 'Drive', icon: 'stick', view: DrivePage, key: 'd' },
  { name: 'messages', title: 'Messages', icon: 'text', view: MessagesPage, key: 'l' },
  { name: 'plots', title: 'Plots', icon: 'plot', view: PlotsPage, key: 'p' },
  { name: 'network', title: 'Network', icon: 'tree', view: NetworkPage, key: 'n' },
  { name: 'studio', title: 'Studio', icon: 'wrench', view: StudioPage, key: 'c' },
  { name: 'recorder', title: 'Recorder', icon: 'disc', view: RecorderPage, key: 'r' },
  { name: 'simulation', title: 'Simulation', icon: 'cube', view: SimulationPage, key: 's' },
];

const viewOf = (name: string) => (name === 'robot' ? RobotPage : pages.find((page) => page.name === name)?.view);

export function App() {
  const { page, arguments: rest } = route.value;
  const title = page === 'robot' ? `Robot ${rest[0] ?? ''}` : (pages.find(({ name }) => name === page)?.title ?? page);
  useEffect(() => {
    document.title = `${title} - RACK`;
  }, [title]);
  return (
    <>
      <button type="button" class="skip" onClick={() => document.getElementById('content')?.focus()}>
        Skip to the content
      </button>
      <header class="bar">
        <a class="brand" href="#/fleet">
          RACK
        </a>
        <Navigation current={page} />
        <span class="grow" />
        <ConnectionBadge />
        <LoginBadge />
        <LayoutMenu />
        <ThemeSwitch />
        <StopButton />
      </header>
      <ExposedNotice />
      <ConnectionNotice />
      <ChangeWatch />
      <main id="content" tabIndex={-1} class={`page-${page}`}>
        <Boundary key={`${page}/${rest[0] ?? ''}`} what="page">
          <PageView page={page} />
        </Boundary>
      </main>
      <Palette pages={pages} />
      <Keys pages={pages.map(({ key, name, title: text }) => ({ key, text, run: () => go(parseRoute(name)) }))} />
    </>
  );
}

// On a phone the first four are at the bottom, the others in a menu beside them.
const atThumb = 4;

function Navigation({ current }: { current: string }) {
  const link = ({ name, title, icon }: Page) => (
    <a key={name} href={`#/${name}`} aria-current={current === name ? 'page' : undefined}>
      <Icon name={icon} />
      <span>{title}</span>
    </a>
  );
  return (
    <nav aria-label="Pages">
      {pages.slice(0, atThumb).map(link)}
      <span class="wide">{pages.slice(atThumb).map(link)}</span>
      <details class="narrow" key={current}>
        <summary class={pages.slice(atThumb).some(({ name }) => name === current) ? 'current' : ''}>
          <Icon name="more" />
          <span>More</span>
        </summary>
        <div>{pages.slice(atThumb).map(link)}</div>
      </details>
    </nav>
  );
}

function PageView({ page }: { page: string }) {
  const View = viewOf(page);
  if (View !== undefined) return <View />;
  return (
    <section class="empty">
      <h1>There is no page “{page}”</h1>
      <p>
        <a href="#/fleet">Go to the fleet</a>
      </p>
    </section>
  );
}
